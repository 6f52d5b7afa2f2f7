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

// The next picture of a display: its display time and one camera per eye.
struct PlannedFrame {
  uint64_t index = 0;
  int64_t display_time_ns = 0;  // on the display's clock, from its first frame
  std::vector<Camera> views;
  bool kept = true;  // false: no display and no file needs the picture, so it is not drawn
};

// A target for pictures: a headset, a window, or files. Used by one thread: wait_frame, draw each view,
// submit.
class Display {
 public:
  virtual ~Display() = default;

  // Blocks until the next picture is due. Nothing when the display was closed.
  virtual std::optional<PlannedFrame> wait_frame() = 0;
  // One image per view.
  virtual Result<void> submit(const PlannedFrame& frame, std::span<const Image> images) = 0;
  // Ends the output and waits until all pictures are written or shown.
  virtual Result<void> finish() = 0;
};

}  // namespace livegs
