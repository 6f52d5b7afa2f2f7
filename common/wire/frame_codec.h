// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/result.h"
#include "skin/driver_frame.h"

// Converts a DriverFrame to bytes and back. proto/frame_format.md specifies the byte layout and takes
// precedence.

namespace livegs {

// Protocol version, compared when a client joins. Increased by any change of the byte layout or of RestBody.
inline constexpr uint32_t kProtocolVersion = 5;

// Maximum size of a frame, bytes. Decoders reject larger ones.
inline constexpr size_t kMaxFrameBytes = 64u << 20;

// A self-contained frame. Quantised: positions with 16 bits per axis in the box of the object, poses with 21
// bits per axis in the box of the frame and 62-bit smallest-three quaternions. The position error is at most
// half a step: box edge / 65535 / 2. Raw: floats. Preconditions: values are finite, also as floats.
enum class DriverEncoding : uint8_t { Quantised = 0, Raw = 1 };
std::vector<std::byte> encode_frame(const DriverFrame& frame,
                                    DriverEncoding encoding = DriverEncoding::Quantised);

// Accepts any bytes; invalid ones give an error. Memory is bounded by the size of the input.
Result<DriverFrame> decode_frame(std::span<const std::byte> bytes);

}  // namespace livegs
