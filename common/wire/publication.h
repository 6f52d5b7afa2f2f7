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

// A frame for anybody who listens; proto/frame_format.md, "Publications".

namespace livegs {

struct Publication {
  std::string server_instance;  // 32 hexadecimal digits
  uint64_t event_number = 0;    // of the scene that the frame is of
  int64_t stepped_ns = 0;       // the monotonic clock of the machine: its step was done
  DriverFrame frame;
};

std::vector<std::byte> encode_publication(const Publication& publication);
// Accepts any bytes; memory is bounded by kMaxFrameBytes.
Result<Publication> decode_publication(std::span<const std::byte> bytes);

}  // namespace livegs
