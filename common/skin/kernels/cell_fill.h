// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>

// The material distribution in a cell, as 64 bits: one for each of 4 x 4 x 4 parts of the cell, bit x + 4 y +
// 16 z. Two fingers that pass through the same cell have one cell each at the same place. A point is bound to
// the cell with the nearest material.

namespace livegs {

inline constexpr int kFillParts = 4;
inline constexpr uint64_t kFullCell = ~uint64_t{0};

// The parts that a box touches; at least one. Cell units, 0 to 1 from face to face.
uint64_t fill_of_box(const Eigen::Vector3f& low, const Eigen::Vector3f& high);

// Distances of a point from the material of a cell, compared in order: to its parts, to the cell, and to the
// centre of the material. The last separates two materials in the same part.
struct FillDistance {
  float to_material = 0.0f, to_cell = 0.0f, to_middle = 0.0f;  // squared, in cell widths
  bool operator<(const FillDistance& other) const {
    if (to_material != other.to_material) return to_material < other.to_material;
    if (to_cell != other.to_cell) return to_cell < other.to_cell;
    return to_middle < other.to_middle;
  }
};
// `point` is in cell units from corner 0 of the cell. A cell without material counts as full.
FillDistance fill_distance(uint64_t fill, const Eigen::Vector3f& point);

}  // namespace livegs
