// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/result.h"
#include "splat/camera.h"
#include "splat/image.h"

namespace livegs {

// The next picture a display wants: when it will be seen, and from where, one camera an eye.
struct PlannedFrame {
  uint64_t index = 0;
  int64_t display_time_ns = 0;  // on the display's own clock, from its first frame
  std::vector<Camera> views;
};

// Where pictures go: a headset, a window, or files. One thread drives it: wait_frame, draw each view, submit.
class Display {
 public:
  virtual ~Display() = default;

  // Blocks until the next picture should be drawn. Nothing when the display was closed.
  virtual std::optional<PlannedFrame> wait_frame() = 0;
  // One image a view.
  virtual Result<void> submit(const PlannedFrame& frame, std::span<const Image> images) = 0;
  // No more pictures; waits until all are where they belong.
  virtual Result<void> finish() = 0;
};

}  // namespace livegs
