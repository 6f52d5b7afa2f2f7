// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/result.h"
#include "skin/rest_body.h"

// RestBody to bytes and back, exactly; proto/frame_format.md, "Rest state of an object".

namespace livegs {

// No rest body is larger; a decoder refuses more. A lattice of a million nodes has 38 MB.
inline constexpr size_t kMaxRestBodyBytes = 64u << 20;

// Of RestBody::revision: a frame has one byte for it. An object has at most 256 bodies, so it breaks less
// often.
inline constexpr uint32_t kMaxRevision = 255;

// Preconditions: values are finite, quaternions unit, scale and cell width positive, and cells name nodes
// that exist.
std::vector<std::byte> encode_rest_body(const RestBody& rest);

// Accepts any bytes and answers with an error for those that are no rest body. Memory is bounded by the
// input's size.
Result<RestBody> decode_rest_body(std::span<const std::byte> bytes);

}  // namespace livegs
