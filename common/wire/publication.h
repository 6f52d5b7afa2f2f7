// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "skin/driver_frame.h"

// A frame for any subscriber. See proto/frame_format.md, "Publications".

namespace livegs {

struct Publication {
  std::string server_instance;  // 32 hexadecimal digits
  uint64_t event_number = 0;    // event number of the scene at this frame
  int64_t stepped_ns = 0;       // end of the step, on the monotonic clock of the server's machine
  DriverFrame frame;
};

std::vector<std::byte> encode_publication(const Publication& publication);
// Accepts any bytes; memory is bounded by kMaxFrameBytes.
Result<Publication> decode_publication(std::span<const std::byte> bytes);

}  // namespace livegs
