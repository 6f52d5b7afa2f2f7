// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/live/analysis_controller.h"

#include <pthread.h>

#include <algorithm>

#include "analysis/gate/answer.h"
#include "analysis/physics_file.h"
#include "analysis/sidecar/manual_edits.h"
#include "core/log.h"
#include "core/text/format_text.h"
#include "core/text/shown_text.h"
#include "session/support/redact_paths.h"

namespace livegs {
namespace {

v1::AnalysisProgress::Stage stage_of(AnalysisStage stage) {
  switch (stage) {
    case AnalysisStage::Asked:
      return v1::AnalysisProgress::ASKED;
    case AnalysisStage::Repaired:
      return v1::AnalysisProgress::REPAIRED;
    case AnalysisStage::Finished:
      return v1::AnalysisProgress::FINISHED;
    default:
      return v1::AnalysisProgress::OFFLINE;
  }
}

v1::AnalysisProgress::Verdict verdict_of(const AnalysisUpdate& update) {
  if (update.turns.empty()) return v1::AnalysisProgress::NOT_ASKED;
  switch (update.judgement.verdict) {
    case Verdict::Accepted:
      return v1::AnalysisProgress::ACCEPTED;
    case Verdict::NeedsReview:
      return v1::AnalysisProgress::NEEDS_REVIEW;
    default:
      return v1::AnalysisProgress::REFUSED;
  }
}

constexpr const char* kDecisionRemedy =
    "accept it in the window or with livegs analyze --accept; decline it there, with --decline, or by "
    "editing the object";

// The message without server paths, for clients; logs the full message if they differ.
std::string client_message_of(const std::string& object, const std::string& message) {
  std::string line = redact_paths(message);
  if (line != message) log_warn("%s: %s", shown_text(object, 80).c_str(), message.c_str());
  return line;
}

const std::string& logged(const std::string& object, const std::string& warning) {
  log_warn("%s: %s", shown_text(object, 80).c_str(), warning.c_str());
  return warning;
}

// Logs the result for an object, with the actions open to the user.
void log_finished(const std::string& name, const v1::AnalysisProgress& progress) {
  const std::string shown = shown_text(name, 80);
  const std::string why = progress.message().empty() ? "" : ": " + progress.message();
  switch (progress.verdict()) {
    case v1::AnalysisProgress::ACCEPTED:
      return log_info("analysis: %s: accepted%s", shown.c_str(), why.c_str());
    case v1::AnalysisProgress::NEEDS_REVIEW:
      return log_info("analysis: %s: needs review%s; kept as a proposal; %s", shown.c_str(), why.c_str(),
                      kDecisionRemedy);
    case v1::AnalysisProgress::REFUSED:
      return log_info("analysis: %s: refused%s", shown.c_str(), why.c_str());
    default:
      return;  // a missing answer is logged once for all objects
  }
}

}  // namespace

AnalysisController::AnalysisController(SceneAnalysis scene, std::unique_ptr<ModelEndpoint> endpoint,
                                       SimulationLoop& loop, const AnalysisControllerOptions& options)
    : endpoint_(std::move(endpoint)),
      loop_(loop),
      options_(options),
      cache_(options.answers),
      scene_(std::move(scene)) {
  for (const SceneAnalysis::Object& object : scene_.objects()) {
    known_[object.target.object_id] = {object, std::make_unique<PhysicsOverrides>(object.physics_file)};
  }
  find_proposals();
  thread_ = std::jthread([this](std::stop_token stop) { run(stop); });
}

AnalysisController::~AnalysisController() = default;

void AnalysisController::begin() {
  std::vector<std::string> names;
  for (const auto& [id, known] : present()) {
    const std::string name = shown_text(known->object.name, 80);
    if (waits(id)) {
      log_info("analysis: %s: a proposal from an earlier run waits; %s", name.c_str(), kDecisionRemedy);
      continue;
    }
    if (known->object.written.behavior() != v1::Physics::AUTO) continue;
    const auto kept = known->decided->present();
    if (!kept || !kept->analysis().model().empty()) continue;
    if (known->decided->answer_undone()) {
      log_info("analysis: %s: skipped: its answer was undone or declined; analyse it again by name",
               name.c_str());
    } else {
      names.push_back(known->object.name);
    }
  }
  if (!endpoint_ || names.empty()) return;
  log_info("analysis: %zu objects are sent to %s", names.size(), endpoint_->state().name.c_str());
  if (auto begun = analyze(
          names, [](const auto&) { return true; }, [] {});
      !begun) {
    log_warn("analysis: %s", begun.error().message.c_str());
  }
}

void AnalysisController::find_proposals() {
  for (const auto& [id, known] : present()) {
    if (const auto proposal = known->decided->proposal()) {
      add_proposal(id, *proposal);
    } else {
      remove_proposal(id);  // accepted by another program
    }
  }
}

void AnalysisController::add_proposal(uint32_t object_id, const v1::PhysicsFile& proposal) {
  std::lock_guard lock(mutex_);
  v1::PhysicsFile& waiting = proposals_[object_id];
  waiting = proposal;
  if (proposed_) proposed_(known_.at(object_id).object.name, &waiting);
}

void AnalysisController::remove_proposal(uint32_t object_id) {
  std::lock_guard lock(mutex_);
  if (proposals_.erase(object_id) > 0 && proposed_) proposed_(known_.at(object_id).object.name, nullptr);
}

bool AnalysisController::waits(uint32_t object_id) {
  std::lock_guard lock(mutex_);
  return proposals_.contains(object_id);
}

void AnalysisController::watch_proposals(Proposed proposed) {
  std::lock_guard lock(mutex_);
  proposed_ = std::move(proposed);
  if (!proposed_) return;
  for (const auto& [id, proposal] : proposals_) proposed_(known_.at(id).object.name, &proposal);
}

SceneAnalysis::Object AnalysisController::loaded(const Known& known) {
  std::lock_guard lock(mutex_);
  const auto reloaded = reloaded_.find(known.object.target.object_id);
  return reloaded == reloaded_.end() ? known.object : reloaded->second;
}

AnalysisController::Known& AnalysisController::at(uint32_t object_id) {
  std::lock_guard lock(mutex_);
  return known_.at(object_id);
}

std::vector<std::pair<uint32_t, AnalysisController::Known*>> AnalysisController::present() {
  std::lock_guard lock(mutex_);
  std::vector<std::pair<uint32_t, Known*>> all;
  for (auto& [id, known] : known_) {
    if (!known.gone) all.emplace_back(id, &known);
  }
  return all;
}

SceneAnalysis AnalysisController::snapshot() {
  std::lock_guard lock(mutex_);
  return scene_;
}

void AnalysisController::change(const std::vector<std::string>& gone, std::span<const BuiltObject> fresh) {
  std::lock_guard deciding(deciding_);
  std::lock_guard lock(mutex_);
  auto changed = scene_.changed(gone, fresh, next_id_);
  if (!changed) {
    log_warn("analysis: %s", changed.error().message.c_str());
    return;
  }
  for (auto& [id, known] : known_) {
    if (!known.gone && std::find(gone.begin(), gone.end(), known.object.name) != gone.end()) {
      known.gone = true;
      if (proposals_.erase(id) > 0 && proposed_) proposed_(known.object.name, nullptr);
    }
  }
  scene_ = std::move(*changed);
  for (const SceneAnalysis::Object& object : scene_.objects()) {
    const uint32_t id = object.target.object_id;
    if (id < next_id_ || known_.contains(id)) continue;
    Known& known = known_[id] = {object, std::make_unique<PhysicsOverrides>(object.physics_file)};
    if (const auto proposal = known.decided->proposal()) {
      v1::PhysicsFile& waiting = proposals_[id] = *proposal;
      if (proposed_) proposed_(object.name, &waiting);
    }
  }
  next_id_ += static_cast<uint32_t>(fresh.size());
}

void AnalysisController::replace(Scene scene) {
  std::lock_guard deciding(deciding_);
  const auto reloaded = SceneAnalysis::of(scene, false);
  if (!reloaded)
    log_warn("reset: %s", reloaded.error().message.c_str());  // a sidecar was damaged after loading
  find_proposals();
  std::vector<v1::SceneChange> changes;
  for (const auto& [id, known] : present()) {
    const SceneObject* object = scene.find(known->object.name);
    if (!object || !reloaded) continue;
    for (const SceneAnalysis::Object& one : reloaded->objects()) {
      std::lock_guard lock(mutex_);
      if (one.name == known->object.name) reloaded_[id] = one;
    }
    const auto kept = known->decided->present();
    if (!kept || !(kept->has_physics() || kept->has_edits())) continue;
    if (const auto reply = reply_of(*known, *kept, "")) changes.push_back(change_of(*reply));
  }
  loop_.replace(std::move(scene), std::move(changes));
}

Result<void> AnalysisController::analyze(std::vector<std::string> objects, Progress progress,
                                         std::function<void()> ended, std::stop_token stop) {
  auto targets = snapshot().targets(objects);
  if (!targets) return targets.error();
  std::lock_guard lock(mutex_);
  if (requests_.size() >= kMaxWaiting) {
    return Error{ErrorCode::TooLarge,
                 "analysis: " + std::to_string(kMaxWaiting) + " are waiting, the maximum; try again later"};
  }
  requests_.push_back({std::move(*targets), std::move(progress), std::move(ended), std::move(stop)});
  changed_.notify_one();
  return {};
}

void AnalysisController::run(std::stop_token stop) {
  pthread_setname_np(pthread_self(), "analysis");
  for (;;) {
    std::optional<Request> request;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, stop, [&] { return !requests_.empty(); });
      if (requests_.empty()) return;
      request = std::move(requests_.front());
      requests_.pop_front();
    }
    if (!request->stop.stop_requested()) {
      std::stop_source either;
      const auto end = [&] { either.request_stop(); };
      const std::stop_callback closed(stop, end), cancelled(request->stop, end);
      work(*request, either.get_token());
    }
    request->ended();
  }
}

std::vector<AnalysisNeighbour> AnalysisController::refresh(std::vector<AnalysisTarget>& targets) {
  std::vector<AnalysisNeighbour> others;
  for (const auto& [id, known] : present()) {
    const SceneAnalysis::Object object = loaded(*known);
    const auto asked = std::find_if(targets.begin(), targets.end(),
                                    [&, wanted = id](const auto& one) { return one.object_id == wanted; });
    const auto kept = known->decided->present();
    std::string ignored;
    const auto facts = kept ? facts_by_name(object, *kept) : object.target.facts;
    if (asked == targets.end()) {
      const auto now = kept ? layered_physics(*kept, object.written, *facts, ignored)
                            : Result<v1::PhysicalParameters>(kept.error());
      others.push_back({facts, now ? *now : object.known, object.target.position_m});
    } else if (kept) {
      asked->facts = facts;
      auto offline = offline_physics(*kept, object.written, *facts);
      if (!offline) continue;
      *offline->mutable_longest_side_m() = object.target.offline.longest_side_m();
      asked->offline = std::move(*offline);
    }
  }
  return others;
}

void AnalysisController::work(Request& request, std::stop_token stop) {
  AnalysisOptions options;
  options.neighbours = refresh(request.targets);
  options.views = options_.views;
  options.cache = &cache_;
  uint32_t finished = 0;
  bool client_receives = true;
  const AnalysisSummary summary = analyze_scene(
      request.targets, endpoint_.get(), snapshot().views(), options,
      [&](const AnalysisUpdate& update) {
        const Known& known = at(update.object_id);
        v1::AnalysisProgress progress;
        progress.set_object(known.object.name);
        progress.set_stage(stage_of(update.stage));
        progress.set_objects(static_cast<uint32_t>(request.targets.size()));
        progress.set_message(client_message_of(known.object.name, update.judgement.message));
        *progress.mutable_record() = update.record;
        if (update.stage == AnalysisStage::Finished) {
          ++finished;
          progress.set_verdict(verdict_of(update));
          if (progress.verdict() == v1::AnalysisProgress::NEEDS_REVIEW) {
            *progress.mutable_proposal() = update.judgement.proposal;
            std::lock_guard deciding(deciding_);
            known.decided->propose(update.judgement.proposal, update.record);
            v1::PhysicsFile waiting;
            *waiting.mutable_physics() = update.judgement.proposal;
            *waiting.mutable_analysis() = update.record;
            add_proposal(update.object_id, waiting);  // the scene is unchanged
          }
          if (progress.verdict() == v1::AnalysisProgress::ACCEPTED) {
            if (const std::string note = apply_answer(update); !note.empty())
              progress.set_message(client_message_of(known.object.name, note));
          }
          if (!update.cancelled) log_finished(known.object.name, progress);
        }
        progress.set_finished(finished);
        std::string ignored;
        const auto present = known.decided->present();
        const SceneAnalysis::Object object = loaded(known);
        const auto layered =
            present ? layered_physics(*present, object.written, *facts_by_name(object, *present), ignored)
                    : Result<v1::PhysicalParameters>(present.error());
        *progress.mutable_parameters() = layered ? *layered : update.parameters;
        if (client_receives) client_receives = request.progress(progress);
      },
      stop);
  if (endpoint_) {
    log_info(
        "analysis: %zu objects: %zu accepted (%zu cached), %zu for review, %zu refused, %zu without answer; "
        "%lld tokens in, %lld out",
        summary.objects, summary.accepted, summary.cached, summary.review, summary.refused, summary.failed,
        static_cast<long long>(summary.prompt_tokens), static_cast<long long>(summary.completion_tokens));
  }
}

std::string AnalysisController::apply_answer(const AnalysisUpdate& update) {
  const Known& known = at(update.object_id);
  std::string note;
  std::lock_guard deciding(deciding_);
  auto file = known.decided->apply(update.parameters, update.record, note);
  if (!file) return file.error().message;
  remove_proposal(update.object_id);
  auto applied = apply(known, *file, note);
  if (!applied) return applied.error().message;
  std::string warnings;
  for (const std::string& warning : applied->warnings()) warnings += (warnings.empty() ? "" : "; ") + warning;
  return warnings;
}

Result<v1::PhysicsReply> AnalysisController::reply_of(const Known& known, const v1::PhysicsFile& file,
                                                      const std::string& note) {
  const SceneAnalysis::Object object = loaded(known);
  v1::PhysicsReply reply;
  if (!note.empty()) reply.add_warnings(redact_paths(logged(object.name, note)));
  std::string size_note;
  auto layered = layered_physics(file, object.written, *facts_by_name(object, file), size_note);
  if (!layered) return layered.error();
  if (!size_note.empty()) reply.add_warnings(logged(object.name, size_note));
  *layered->mutable_longest_side_m() = object.target.offline.longest_side_m();
  reply.set_object(object.name);
  for (const std::string& later : lock_body_type(object.built, *layered))
    reply.add_warnings(logged(object.name, later));
  *reply.mutable_parameters() = std::move(*layered);
  return reply;
}

v1::SceneChange AnalysisController::change_of(const v1::PhysicsReply& reply) {
  v1::SceneChange change;
  change.mutable_set_physics()->set_object(reply.object());
  *change.mutable_set_physics()->mutable_physics() = reply.parameters();
  return change;
}

Result<v1::PhysicsReply> AnalysisController::apply(const Known& known, const v1::PhysicsFile& file,
                                                   const std::string& note) {
  auto reply = reply_of(known, file, note);
  if (reply) loop_.post(change_of(*reply));
  return reply;
}

Result<AnalysisController::Known*> AnalysisController::find(const std::string& name) {
  auto targets = snapshot().targets({name});
  if (!targets) return targets.error();
  return &at(targets->front().object_id);
}

Result<v1::PhysicsReply> AnalysisController::set_physics(const std::string& object,
                                                         const v1::Physics& physics,
                                                         const std::string& name) {
  auto known = find(object);
  if (!known) return known.error();
  if (auto checked = check_scene_physics(physics); !checked) {
    return Error{checked.error().code, "physics." + checked.error().message};
  }
  std::string note;
  std::lock_guard deciding(deciding_);
  auto file = (*known)->decided->edit(physics, name, note);
  if (!file) return file.error();
  remove_proposal((*known)->object.target.object_id);
  if (!name.empty() && file->has_physics()) {
    note += (note.empty() ? "" : "; ") +
            std::string("the values were estimated under another name; analyse it again");
  }
  const std::string unheard = overridden_edits(physics, loaded(**known).written);
  if (!unheard.empty()) note += (note.empty() ? "" : "; ") + unheard;
  return apply(**known, *file, note);
}

Result<v1::PhysicsReply> AnalysisController::accept_proposal(const std::string& object) {
  auto known = find(object);
  if (!known) return known.error();
  std::string note;
  std::lock_guard deciding(deciding_);
  auto file = (*known)->decided->accept(note);
  if (!file) return file.error();
  remove_proposal((*known)->object.target.object_id);
  return apply(**known, *file, note);
}

Result<v1::PhysicsReply> AnalysisController::decline_proposal(const std::string& object) {
  auto known = find(object);
  if (!known) return known.error();
  std::string note;
  std::lock_guard deciding(deciding_);
  auto file = (*known)->decided->decline(note);
  if (!file) return file.error();
  remove_proposal((*known)->object.target.object_id);
  return reply_of(**known, *file, note);
}

Result<v1::PhysicsReply> AnalysisController::restore_estimate(const std::string& object,
                                                              std::span<const std::string> fields) {
  auto known = find(object);
  if (!known) return known.error();
  std::string note;
  std::lock_guard deciding(deciding_);
  auto file = (*known)->decided->restore(fields, note);
  if (!file) return file.error();
  remove_proposal((*known)->object.target.object_id);
  return apply(**known, *file, note);
}

Result<v1::PhysicsReply> AnalysisController::undo_physics(const std::string& object, bool redo) {
  auto known = find(object);
  if (!known) return known.error();
  std::string note;
  std::lock_guard deciding(deciding_);
  auto file = (*known)->decided->step(redo, note);
  if (!file) return file.error();
  return apply(**known, *file, note);
}

}  // namespace livegs
