// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <span>
#include <string>

#include "core/result.h"
#include "livegs/v1/physics.pb.h"
#include "material/part_places.h"

namespace livegs {

// Limit of a part. More boxes follow noise of the kernels instead of the form.
inline constexpr int kMaxPartBoxes = 16;

// Sets the boxes of a part; a corner with an infinite coordinate is left out, so that its sides are open.
void set_boxes(std::span<const Eigen::AlignedBox3d> boxes, v1::MaterialPart& part);
// Multiplies all boxes, for an object whose size changes.
void scale_parts(double factor, MaterialParts& parts);
// One line: "pot of terracotta, 40 % of the mass, 1900 kg/m3, 2 boxes"; what is unknown is left out.
std::string part_line(const v1::MaterialPart& part);
// Checks names, materials, shares, limits and boxes that a person or an author wrote. The error begins with
// "parts[0].mass_share" or the like. Parts that get no place are known when the body is built.
Result<void> check_parts(const MaterialParts& parts);

}  // namespace livegs
