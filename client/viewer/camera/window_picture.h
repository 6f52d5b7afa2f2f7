// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "render/scene_view.h"
#include "viewer/camera/orbit_camera.h"
#include "viewer/camera/render_scale.h"
#include "viewer/camera/still_picture.h"

namespace livegs {

// The picture of a scene in a window: reduced to stay within a time budget while something moves, at full
// size with all kernels when camera and scene rest, and not drawn again after that. One thread.
class WindowPicture {
 public:
  explicit WindowPicture(double budget_ms) : scale_(budget_ms) {}

  // Draws the pose of `view`, if the last picture is not of this pose, camera and window size.
  Result<void> draw(SceneView& view, const OrbitCamera& camera, const Eigen::Vector2i& window_px,
                    int64_t now_ns);
  // The picture of the last draw(); empty if the previous picture is still valid.
  std::span<const Image> drawn() const { return std::span(images_).first(drawn_ ? images_.size() : 0); }
  // Makes the next draw() draw a picture. Call after the window has shown something else.
  void reset() {
    still_.reset();
    drawn_ = false;
  }

  bool rests() const { return still_.rests(); }
  // Time for which the window may wait for events before the next draw().
  double wait_s(int64_t now_ns) const { return drawn_ ? 0 : still_.wait_s(now_ns); }
  // Resolution and culling, for a line of the panel.
  std::string text() const;

 private:
  RenderScale scale_;
  StillPicture still_;
  bool drawn_ = false;
  std::vector<Image> images_;
};

}  // namespace livegs
