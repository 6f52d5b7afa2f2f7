// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>

// Where the material of a cell is, in 64 bits: one for each of 4 x 4 x 4 parts of the cell, bit x + 4 y + 16
// z. Two fingers that pass through one cell have a cell each at the same place; a point rides in the one
// whose material is nearest.

namespace livegs {

inline constexpr int kFillParts = 4;
inline constexpr uint64_t kFullCell = ~uint64_t{0};

// The parts that a box touches, in cell units: 0 ... 1 from face to face. At least one.
uint64_t fill_of_box(const Eigen::Vector3f& low, const Eigen::Vector3f& high);

// How far a point is from the material of a cell, nearest first: from its parts, then from the cell itself,
// then from the middle of the material, which tells two materials in one part from each other.
struct FillDistance {
  float to_material = 0.0f, to_cell = 0.0f, to_middle = 0.0f;  // squared, in cell widths
  bool operator<(const FillDistance& other) const {
    if (to_material != other.to_material) return to_material < other.to_material;
    if (to_cell != other.to_cell) return to_cell < other.to_cell;
    return to_middle < other.to_middle;
  }
};
// `point` in cell units from the cell's corner 0. A cell without material counts as full.
FillDistance fill_distance(uint64_t fill, const Eigen::Vector3f& point);

}  // namespace livegs
