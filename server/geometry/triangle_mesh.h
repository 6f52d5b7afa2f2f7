// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace livegs {

// Indexed triangles, metres, counter-clockwise as seen from outside.
struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices_m;
  std::vector<std::array<uint32_t, 3>> triangles;
};

}  // namespace livegs
