// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/analyze_scene.h"

#include <pthread.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "analysis/run/ask_model.h"
#include "analysis/run/view_prefetcher.h"
#include "core/log.h"
#include "core/serial_here.h"

namespace livegs {
namespace {

// Lowers the priority of this thread, which packs and sends pictures, below threads with deadlines.
void step_behind() {
  pthread_setname_np(pthread_self(), "analysis");
  (void)::setpriority(PRIO_PROCESS, static_cast<id_t>(::syscall(SYS_gettid)), 15);
  set_serial_here(true);
}

SceneObjectFacts facts_for_others(const AnalysisNeighbour& one, bool analysed,
                                  const Eigen::Vector3d& from_m) {
  SceneObjectFacts facts;
  const v1::PhysicalParameters& known = one.known;
  facts.name = one.facts->name;
  facts.material = known.material();
  facts.behavior = known.behavior() == v1::Physics::ELASTIC  ? "elastic"
                   : known.behavior() == v1::Physics::STATIC ? "static"
                                                             : "rigid";
  facts.mass_kg = known.mass_kg().best();
  facts.size_m = one.facts->mesh.size_m;
  facts.distance_m = (one.position_m - from_m).norm();
  facts.analysed = analysed;
  return facts;
}

// Objects in flight and finished objects. Any thread.
class Course {
 public:
  Course(std::span<const AnalysisTarget> targets, std::span<const AnalysisNeighbour> others)
      : targets_(targets), others_(others), done_(targets.size()) {}

  // Returns the next object once all its neighbours in range are finished; nullopt after the last one or on a
  // stop.
  std::optional<size_t> take(std::stop_token stop) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, stop, [&] { return next_ >= targets_.size() || next_ < first_open_ + kContextLag; });
    if (stop.stop_requested() || next_ >= targets_.size()) return std::nullopt;
    return next_++;
  }
  void finish(size_t index, v1::PhysicalParameters known, bool analysed) {
    std::lock_guard lock(mutex_);
    done_[index] = {std::move(known), analysed};
    while (first_open_ < done_.size() && done_[first_open_]) ++first_open_;
    changed_.notify_all();
  }
  // At most kMaxNeighbours: first estimates, then objects known from a user, the scene or a model, each group
  // with the nearest last; then finished ones within the context lag, newest last.
  std::vector<SceneObjectFacts> neighbours_of(size_t index) {
    std::lock_guard lock(mutex_);
    std::vector<SceneObjectFacts> estimated, given, analysed;
    const auto add = [&](const AnalysisNeighbour& one, std::vector<SceneObjectFacts>& known) {
      const bool estimate = one.known.mass_kg().source() == v1::EstimatedValue::OFFLINE;
      (estimate ? estimated : known).push_back(facts_for_others(one, !estimate, targets_[index].position_m));
    };
    for (const AnalysisNeighbour& one : others_) add(one, given);
    for (size_t i = 0; i < targets_.size(); ++i) {
      if (i == index) continue;
      const AnalysisTarget& one = targets_[i];
      const bool visible = i + kContextLag <= index;
      const bool by_model = visible && done_[i]->second;
      add({one.facts, visible ? done_[i]->first : one.offline, one.position_m}, by_model ? analysed : given);
    }
    for (auto* group : {&estimated, &given}) {
      std::stable_sort(group->begin(), group->end(),
                       [](const auto& a, const auto& b) { return a.distance_m > b.distance_m; });
    }
    estimated.insert(estimated.end(), given.begin(), given.end());
    estimated.insert(estimated.end(), analysed.begin(), analysed.end());
    if (estimated.size() > kMaxNeighbours) {
      estimated.erase(estimated.begin(), estimated.end() - static_cast<long>(kMaxNeighbours));
    }
    return estimated;
  }

 private:
  std::span<const AnalysisTarget> targets_;
  std::span<const AnalysisNeighbour> others_;
  std::mutex mutex_;  // guards the members below
  std::condition_variable_any changed_;
  size_t next_ = 0, first_open_ = 0;
  std::vector<std::optional<std::pair<v1::PhysicalParameters, bool>>> done_;
};

}  // namespace

AnalysisSummary analyze_scene(std::span<const AnalysisTarget> targets, ModelEndpoint* endpoint,
                              const TargetViews& views, const AnalysisOptions& asked,
                              const std::function<void(const AnalysisUpdate&)>& update,
                              std::stop_token stop) {
  AnalysisOptions options = asked;
  if (endpoint && options.prompt_version.empty()) {
    options.prompt_version = endpoint->state().prompt_version;
  }
  AnalysisSummary summary;
  summary.objects = targets.size();
  std::mutex mutex;  // serialises calls of update, and guards summary
  const auto offline_of = [&](size_t index) {
    AnalysisUpdate first;
    first.index = index;
    first.object_id = targets[index].object_id;
    first.parameters = first.judgement.parameters = targets[index].offline;
    return first;
  };
  for (size_t i = 0; i < targets.size(); ++i) update(offline_of(i));

  if (endpoint) endpoint->get_ready(stop);  // a question's hash includes the model's name
  const EndpointState known = endpoint ? endpoint->state() : EndpointState{};
  Course course(targets, options.neighbours);
  std::vector<bool> finished(targets.size(), false);
  const auto report = [&](const AnalysisUpdate& one) {
    std::lock_guard lock(mutex);
    if (one.stage == AnalysisStage::Finished) {
      finished[one.index] = true;
      const bool answered = !one.turns.empty();
      if (one.judgement.verdict == Verdict::Accepted)
        ++summary.accepted;
      else if (one.judgement.verdict == Verdict::NeedsReview)
        ++summary.review;
      else if (answered)
        ++summary.refused;
      else
        ++summary.failed;
      if (one.cached) ++summary.cached;
      summary.prompt_tokens += one.record.prompt_tokens();
      summary.completion_tokens += one.record.completion_tokens();
      summary.cost_usd += one.record.cost_usd();
      summary.slowest_views_s = std::max(summary.slowest_views_s, one.views_s);
      if (!answered && summary.failure.empty() && !one.cancelled) {
        summary.failure = one.judgement.message;
        if (endpoint) log_warn("analysis: offline estimates are used: %s", summary.failure.c_str());
      }
    }
    update(one);
  };
  std::optional<ViewPrefetcher> ahead;
  const auto work = [&] {
    step_behind();
    while (const auto index = course.take(stop)) {
      AnalysisUpdate one = offline_of(*index);
      const TargetViews drawn = [&](uint32_t, int, std::stop_token) {
        ViewPrefetcher::Made made = ahead->take(*index);
        one.views_s = made.wall_s;
        return std::move(made.views);
      };
      ask_model(
          targets[*index], course.neighbours_of(*index), *endpoint, known, drawn, options,
          [&](AnalysisStage stage) {
            one.stage = stage;
            report(one);
          },
          stop, one);
      one.stage = AnalysisStage::Finished;
      report(one);
      course.finish(*index, one.parameters, one.judgement.verdict == Verdict::Accepted);
    }
  };
  if (endpoint && !targets.empty()) {
    ahead.emplace(targets, views, options, stop);
    const auto limit = static_cast<size_t>(std::max(1, endpoint->state().max_in_flight));
    std::vector<std::jthread> workers;
    for (size_t i = 0; i < std::min({limit, kContextLag, targets.size()}); ++i) workers.emplace_back(work);
  }
  if (summary.slowest_views_s > kViewTimeWarning_s) {
    log_warn(
        "analysis: rendering the views of an object took up to %.1f s (usually below %.0f s); the machine is "
        "slow or busy",
        summary.slowest_views_s, kViewTimeWarning_s);
  }
  // Objects that were not queried keep their estimate.
  for (size_t i = 0; i < targets.size(); ++i) {
    if (finished[i]) continue;
    AnalysisUpdate last = offline_of(i);
    last.stage = AnalysisStage::Finished;
    last.cancelled = endpoint && stop.stop_requested();
    last.judgement.message = !endpoint ? "no model endpoint is set" : "cancelled";
    report(last);
  }
  return summary;
}

}  // namespace livegs
