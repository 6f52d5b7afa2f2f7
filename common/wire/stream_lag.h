// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "wire/frame_stream.h"

namespace livegs {

// The lag of the reader of a stream behind a frame, per object.
struct ObjectLag {
  uint32_t object_id = 0;
  double moved_m = 0;      // largest distance of a driver from the reader's state
  double turned_rad = 0;   // largest rotation of a driver since then
  uint64_t age_ticks = 0;  // ticks since the last frame that held the object
  uint64_t integers = 0;   // integers needed to send it
};

// The objects of the next frame that may be left out, because the reader has them in the same form. In the
// order of the frame. `precision`: that of the stream. Any thread.
std::vector<ObjectLag> lag_behind(const DriverFrame& frame, const StreamBaseline& baseline,
                                  const GridPrecision& precision = {});

}  // namespace livegs
