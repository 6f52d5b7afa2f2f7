// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

namespace livegs {

// Fragments of one object, at most.
inline constexpr uint32_t kMaxBodiesOfObject = 256;

// A body by one number, unique in the world: of an elastic object the only one, of a rigid one that or a
// fragment.
inline uint64_t body_id_of(uint32_t object_id, uint32_t body_index = 0) {
  return uint64_t{object_id} * kMaxBodiesOfObject + body_index;
}

inline uint32_t object_of_body(uint64_t body_id) {
  return static_cast<uint32_t>(body_id / kMaxBodiesOfObject);
}

}  // namespace livegs
