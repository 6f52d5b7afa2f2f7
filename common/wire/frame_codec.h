// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/result.h"
#include "skin/driver_frame.h"

// DriverFrame to bytes and back. The byte layout is specified in proto/frame_format.md; that page comes
// first.

namespace livegs {

// The version both ends compare when a client joins. Raised by any change of the byte layout or of RestBody.
inline constexpr uint32_t kProtocolVersion = 5;

// No frame is larger; a decoder refuses more.
inline constexpr size_t kMaxFrameBytes = 64u << 20;

// A self-contained frame. Positions are quantised to 16 bits an axis in the object's own box, poses to 21
// bits an axis in the frame's box and 62-bit smallest-three quaternions; the error bound of a position is
// half a step: box edge / 65535 / 2; or raw, as floats. Preconditions: values are finite, in float too.
enum class DriverEncoding : uint8_t { Quantised = 0, Raw = 1 };
std::vector<std::byte> encode_frame(const DriverFrame& frame,
                                    DriverEncoding encoding = DriverEncoding::Quantised);

// Accepts any bytes and answers with an error for those that are no frame. Memory is bounded by the input's
// size.
Result<DriverFrame> decode_frame(std::span<const std::byte> bytes);

}  // namespace livegs
