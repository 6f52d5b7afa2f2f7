// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>

#include "geometry/triangle_mesh.h"

namespace livegs {

// Every triangle in equal small ones whose edges are at most `edge_m` long (none is cut into more than 512²
// of them), in order, each by its centre and its area in m².
void for_each_triangle_piece(
    const TriangleMesh& mesh, double edge_m,
    const std::function<void(const Eigen::Vector3d& centre_m, double area_m2)>& visit);

}  // namespace livegs
