// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <span>
#include <string>

#include "core/result.h"
#include "livegs/v1/physics.pb.h"
#include "material/part_places.h"

namespace livegs {

// Limit of boxes per part. More boxes would model noise of the kernels.
inline constexpr int kMaxPartBoxes = 16;

// Sets the boxes of a part; a corner with an infinite coordinate is left out, so that its sides are open.
void set_boxes(std::span<const Eigen::AlignedBox3d> boxes, v1::MaterialPart& part);
// Multiplies all boxes, for an object whose size changes.
void scale_parts(double factor, MaterialParts& parts);
// One line: "pot of terracotta, 40 % of the mass, 1900 kg/m3, 2 boxes"; unknown values are omitted.
std::string part_line(const v1::MaterialPart& part);
// Checks names, materials, shares, limits and boxes of a user or an author. The error begins with the field,
// such as "parts[0].mass_share". Parts without a place are detected when the body is built.
Result<void> check_parts(const MaterialParts& parts);

}  // namespace livegs
