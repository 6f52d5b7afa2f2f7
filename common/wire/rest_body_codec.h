// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/result.h"
#include "skin/rest_body.h"

// Lossless codec of RestBody. See proto/frame_format.md, "Rest state of an object".

namespace livegs {

// Maximum size of a rest body, bytes; decoders reject larger ones. A lattice of a million nodes has 38 MB.
inline constexpr size_t kMaxRestBodyBytes = 64u << 20;

// Maximum of RestBody::revision, which has one byte in a frame. An object has at most 256 bodies, so it
// breaks fewer times.
inline constexpr uint32_t kMaxRevision = 255;

// Preconditions: values are finite, quaternions unit, scale and cell width positive, and cells refer to
// existing nodes.
std::vector<std::byte> encode_rest_body(const RestBody& rest);

// Accepts any bytes; invalid ones give an error. Memory is bounded by the size of the input.
Result<RestBody> decode_rest_body(std::span<const std::byte> bytes);

}  // namespace livegs
