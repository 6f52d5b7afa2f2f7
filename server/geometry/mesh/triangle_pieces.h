// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>

#include "geometry/triangle_mesh.h"

namespace livegs {

// Splits each triangle into equal smaller ones with edges of at most `edge_m` (at most 512² per triangle).
// Calls `visit` for each in order, with its centre and its area in m².
void for_each_triangle_piece(
    const TriangleMesh& mesh, double edge_m,
    const std::function<void(const Eigen::Vector3d& centre_m, double area_m2)>& visit);

}  // namespace livegs
