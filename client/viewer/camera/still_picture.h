// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <utility>

#include "splat/camera.h"

namespace livegs {

// Decides when a window draws the scene: at a reduced size while something moves, once at full size when
// camera and scene rest, and not at all afterwards. One thread.
class StillPicture {
 public:
  // Time without a change after which the picture is drawn at full size. Shorter values draw large pictures
  // in short halts of a drag; longer ones leave a blurred picture.
  static constexpr int64_t kRest_ns = 150'000'000;
  // Maximum waits for events and messages, after a change and at rest. kRestWait_s only bounds the delay of
  // an interrupt of the program; a shorter one costs processor time.
  static constexpr double kAlertWait_s = 0.01, kRestWait_s = 0.25;

  enum class Draw { Moving, Full, Nothing };
  // Returns the kind of picture to draw. `window`: camera of the window's size. `scene_version`:
  // SceneView::version() after pose(). Call in order of time.
  Draw next(const Camera& window, uint64_t scene_version, int64_t now_ns) {
    if (!seen_ || scene_version != scene_version_ || !same(window, window_)) {
      seen_ = true;
      window_ = window;
      scene_version_ = scene_version;
      changed_ns_ = now_ns;
      full_ = rests_ = false;
      return Draw::Moving;
    }
    if (now_ns - changed_ns_ < kRest_ns) return Draw::Nothing;
    rests_ = true;
    return std::exchange(full_, true) ? Draw::Nothing : Draw::Full;
  }
  // Reports that the picture for Draw::Moving was drawn at full size with all kernels.
  void drew_in_full() { full_ = true; }
  // Makes next() draw the next picture. Call after the window has shown something else.
  void reset() { seen_ = full_ = rests_ = false; }

  // True if nothing changed for kRest_ns before the last next(), and the window shows the scene at full size.
  bool rests() const { return rests_; }
  // Time for which the window may wait for events: short after a change, because further changes are likely.
  double wait_s(int64_t now_ns) const {
    return rests_ && now_ns - changed_ns_ > kAlert_ns ? kRestWait_s : kAlertWait_s;
  }

 private:
  // Time after a change in which another is likely and waits are short.
  static constexpr int64_t kAlert_ns = 500'000'000;

  static bool same(const Camera& a, const Camera& b) {
    return a.width == b.width && a.height == b.height && a.focal_x_px == b.focal_x_px &&
           a.focal_y_px == b.focal_y_px && a.centre_x_px == b.centre_x_px && a.centre_y_px == b.centre_y_px &&
           a.near_m == b.near_m && a.world_from_camera.position_m == b.world_from_camera.position_m &&
           a.world_from_camera.orientation.coeffs() == b.world_from_camera.orientation.coeffs();
  }

  bool seen_ = false;
  bool full_ = false;  // the picture is at full size
  bool rests_ = false;
  Camera window_;
  uint64_t scene_version_ = 0;
  int64_t changed_ns_ = 0;
};

}  // namespace livegs
