// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "wire/frame_stream.h"

namespace livegs {

// How far the reader of a stream is behind a frame, object by object.
struct ObjectLag {
  uint32_t object_id = 0;
  double moved_m = 0;      // the largest distance of a driver from where the reader has it
  double turned_rad = 0;   // the largest turn of one
  uint64_t age_ticks = 0;  // since the frame that last held it
  uint64_t integers = 0;   // that it takes
};

// Of the objects that the next frame of the stream would hold, those that may be left out of it: the reader
// has them in the same form. In the frame's order. `precision`: what the stream is written with. Any thread.
std::vector<ObjectLag> lag_behind(const DriverFrame& frame, const StreamBaseline& baseline,
                                  const GridPrecision& precision = {});

}  // namespace livegs
