// SPDX-License-Identifier: Apache-2.0
#include "viewer/runs/window_study.h"

#include <utility>

#include "core/log.h"
#include "viewer/hands/force_arrow.h"
#include "viewer/panels/quantity_text.h"

namespace livegs {

const StreamedObject* object_named(const WindowStudy::Objects& objects, const std::string& name) {
  for (const auto& [id, object] : objects) {
    if (object.name == name && !object.environment) return &object;
  }
  return nullptr;
}

Result<ForceStudy> WindowStudy::study_of(const v1::Event::Force& force, const Objects& objects) const {
  const StreamedObject* object = object_named(objects, force.object());
  const Eigen::Vector3d rest_point_m(force.point_m(0), force.point_m(1), force.point_m(2));
  const auto kernel = object ? view_.nearest_kernel(object->id, rest_point_m) : std::nullopt;
  if (!kernel)
    return not_found("--force: no object is named \"" + force.object() +
                     "\"; start without --force to see the names");
  ForceStudy study;
  study.aim({force.object(), object->id, *kernel, rest_point_m});
  study.choose_force({force.force_n(0), force.force_n(1), force.force_n(2)}, force.duration_s());
  return study;
}

Result<void> WindowStudy::record_at_start(std::span<const v1::Event::Force> forces, const Objects& objects,
                                          const Camera& window) {
  std::vector<ForceStudy> studies;
  for (const v1::Event::Force& force : forces) {
    auto study = study_of(force, objects);
    if (!study) return study.error();
    studies.push_back(*std::move(study));
  }
  study_ = studies.back();
  from_start_ = true;
  return begin(std::move(studies), window);
}

Result<void> WindowStudy::begin(std::vector<ForceStudy> studies, const Camera& window) {
  auto begun = StudyRecording::begin(folder_, std::move(studies), window, rate_hz_);
  if (!begun) return begun.error();
  recording_.emplace(std::move(*begun));
  stream_.record_frames(true);
  return {};
}

Result<void> WindowStudy::act(const PanelActions& actions, const Camera& window) {
  if (actions.force) study_.choose(*actions.force);
  if (actions.apply_force && study_.target()) calls_.apply_force(study_.message());
  if (actions.record_force && study_.target() && !recording_) return begin({study_}, window);
  return {};
}

void WindowStudy::find_kernels_again(uint32_t object_id) {
  study_.find_kernel_again(object_id, view_);
  if (recording_) recording_->find_kernels_again(object_id, view_);
}

void WindowStudy::take_frames() {
  if (!recording_) return;
  for (const ReceivedFrame& frame : stream_.take_recorded()) recording_->add(frame);
  stream_.record_frames(recording_->collecting());
}

void WindowStudy::request_forces() {
  if (!recording_ || !recording_->wants_force()) return;
  for (const ForceStudy& study : recording_->studies()) calls_.apply_force(study.message());
}

Result<void> WindowStudy::take(const ControlCalls::Answer& answer) {
  if (answer.refused) {
    abandon();
    // Without a user to choose another force, the requested recording has failed, whatever the reason.
    if (from_start_) return Error{ErrorCode::Unavailable, "--force: " + answer.refused->message};
    return {};
  }
  force_until_tick_ = answer.tick + static_cast<uint64_t>(study_.duration_s() * rate_hz_);
  if (recording_) recording_->force_taken(answer.tick);
  return {};
}

Result<void> WindowStudy::finish() {
  auto finished = recording_->finish();
  const std::filesystem::path video = recording_->video_path();
  recording_.reset();
  from_start_ = false;
  if (finished && std::filesystem::exists(video)) {  // not if its first picture failed
    recorded_ = video;
    log_info("recording saved: %s", recorded_.c_str());
  }
  return finished;
}

void WindowStudy::abandon() {
  if (!recording_) return;
  recording_->abandon();
  recording_.reset();
  stream_.record_frames(false);
}

Result<void> WindowStudy::cut(const std::string& why) {
  const bool asked_for = from_start_;
  std::string left;
  if (recording_->any_drawn()) {
    const std::string drawn = recording_->drawn(), file = recording_->video_path();
    auto finished = finish();
    if (!finished) return finished;
    left = why + ": " + file + " is incomplete: " + drawn;
  } else {
    abandon();
    left = why + " before the first picture of the recording; no video was written";
  }
  if (asked_for) return Error{ErrorCode::Unavailable, "--force: " + left};
  log_warn("%s", left.c_str());
  return {};
}

Result<bool> WindowStudy::keep(const Image& picture) {
  if (auto kept = recording_->keep(picture); !kept) return kept.error();
  if (recording_->next()) return false;
  if (auto finished = finish(); !finished) return finished.error();
  return true;
}

WindowOverlay WindowStudy::recorded_overlay(const Objects& objects, const Camera& window) const {
  WindowOverlay overlay;
  overlay.panels.shown = false;
  overlay.sentence = recording_->sentence();
  for (size_t i = 0; i < recording_->studies().size(); ++i) {
    if (recording_->acts(i)) draw_study(recording_->studies()[i], objects, window, overlay);
  }
  return overlay;
}

ForcePanel WindowStudy::panel() const {
  ForcePanel panel = study_.shown(recording_ ? recording_->progress() : std::string());
  if (!recording_ && !recorded_.empty()) panel.sentence += " Recorded: " + recorded_;
  return panel;
}

void WindowStudy::draw(const ReceivedFrame& shown, bool over_panel, const Objects& objects,
                       const Camera& window, WindowOverlay& overlay) const {
  for (const HeldByHand& held : shown.hands) {
    draw_force(held.point_m.cast<double>(), held.force_n.cast<double>(), held.object_id, objects, window,
               overlay);
  }
  const bool acts = shown.tick <= force_until_tick_;
  const std::vector<ForceStudy> studies = recording_ ? recording_->studies() : std::vector{study_};
  if (acts || (over_panel && shown.hands.empty())) {
    for (const ForceStudy& study : studies) draw_study(study, objects, window, overlay);
  }
  if (acts || recording_) overlay.sentence = sentence_of(studies);
}

void WindowStudy::draw_force(const Eigen::Vector3d& point_m, const Eigen::Vector3d& force_n,
                             uint32_t object_id, const Objects& objects, const Camera& window,
                             WindowOverlay& overlay) const {
  const auto held = pixel_of(window, point_m);
  if (!held) return;
  const auto object = objects.find(object_id);
  const Eigen::AlignedBox3d box = view_.bounds(object_id);
  const double scale = arrow_metres_per_newton(object == objects.end() ? 0.0 : object->second.mass_kg,
                                               box.isEmpty() ? 0.0 : box.sizes().maxCoeff());
  const auto seen = project_arrow(window, point_m, force_n, scale);
  overlay.arrows.push_back({*held, seen ? std::optional(seen->outline_px) : std::nullopt,
                            quantity_text(force_n.norm(), Unit::Newton)});
}

void WindowStudy::draw_study(const ForceStudy& study, const Objects& objects, const Camera& window,
                             WindowOverlay& overlay) const {
  if (!study.target()) return;
  const auto point_m = view_.kernel_position_m(study.target()->object_id, study.target()->kernel);
  if (point_m) draw_force(*point_m, study.force_n(), study.target()->object_id, objects, window, overlay);
}

}  // namespace livegs
