// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

namespace livegs {

// Maximum number of bodies of one object (fragments after a fracture).
inline constexpr uint32_t kMaxBodiesOfObject = 256;

// Number of a body, unique in the world. An elastic object has one body; a rigid object has one per fragment.
inline uint64_t body_id_of(uint32_t object_id, uint32_t body_index = 0) {
  return uint64_t{object_id} * kMaxBodiesOfObject + body_index;
}

inline uint32_t object_of_body(uint64_t body_id) {
  return static_cast<uint32_t>(body_id / kMaxBodiesOfObject);
}

}  // namespace livegs
