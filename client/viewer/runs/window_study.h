// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "livegs/v1/scene.pb.h"
#include "stream/received/received.h"
#include "viewer/live/control_calls.h"
#include "viewer/live/frame_queue.h"
#include "viewer/study/force_study.h"
#include "viewer/study/study_recording.h"
#include "xr/window_display.h"

namespace livegs {

// The force of the panel in a live window, its arrows, and its recording: forces given at the start, or the
// one that the user records. Renderer thread.
class WindowStudy {
 public:
  using Objects = std::map<uint32_t, StreamedObject>;  // by id

  // `folder`: of recordings. All references must outlive this object.
  WindowStudy(std::filesystem::path folder, double rate_hz, ControlCalls& calls, FrameQueue& stream,
              const SceneView& view)
      : folder_(std::move(folder)), rate_hz_(rate_hz), calls_(calls), stream_(stream), view_(view) {}

  // Records these forces together. NotFound if an object is missing.
  Result<void> record_at_start(std::span<const v1::Event::Force> forces, const Objects& objects,
                               const Camera& window);
  // Aims the force of the panel.
  void aim(ForceStudy::Target target) { study_.aim(std::move(target)); }
  // Applies the user's actions on the panel. Fails if a recording could not begin.
  Result<void> act(const PanelActions& actions, const Camera& window);

  // Updates from the stream: an object with a new description, objects with renumbered kernels.
  void follow(const StreamedObject& object) { study_.follow(object.name, object.id); }
  void find_kernels_again(uint32_t object_id);
  void take_frames();     // for a recording
  void request_forces();  // once a recording has its lead
  // The reply to a force. An error, Unavailable: a recording from the start has failed.
  Result<void> take(const ControlCalls::Answer& answer);

  // Whether the next picture is one of a recording, which draw_next() poses and keep() takes.
  bool draws() const { return recording_ && recording_->next(); }
  bool records() const { return recording_.has_value(); }
  std::optional<DriverFrame> next() const { return recording_->next(); }
  WindowOverlay recorded_overlay(const Objects& objects, const Camera& window) const;
  // Takes the drawn picture. True if it was the last one.
  Result<bool> keep(const Image& picture);
  // Ends a recording that cannot be drawn further, because an object fractured meanwhile.
  Result<void> finish();
  // Ends the recording early: the drawn part is kept. An error, Unavailable, if it was given at the start.
  Result<void> cut(const std::string& why);

  ForcePanel panel() const;
  // Arrows of hands, and of the force while it acts or the mouse is over a panel.
  void draw(const ReceivedFrame& shown, bool over_panel, const Objects& objects, const Camera& window,
            WindowOverlay& overlay) const;

 private:
  Result<ForceStudy> study_of(const v1::Event::Force& force, const Objects& objects) const;
  Result<void> begin(std::vector<ForceStudy> studies, const Camera& window);
  void abandon();
  void draw_force(const Eigen::Vector3d& point_m, const Eigen::Vector3d& force_n, uint32_t object_id,
                  const Objects& objects, const Camera& window, WindowOverlay& overlay) const;
  void draw_study(const ForceStudy& study, const Objects& objects, const Camera& window,
                  WindowOverlay& overlay) const;

  const std::filesystem::path folder_;
  const double rate_hz_;
  ControlCalls& calls_;
  FrameQueue& stream_;
  const SceneView& view_;
  ForceStudy study_;  // of the panel
  std::optional<StudyRecording> recording_;
  bool from_start_ = false;        // recording_ holds the forces given at the start
  std::string recorded_;           // path of the last recording
  uint64_t force_until_tick_ = 0;  // of the last force
};

// The object of this name; null if there is none. Objects may have the name of the environment.
const StreamedObject* object_named(const WindowStudy::Objects& objects, const std::string& name);

}  // namespace livegs
