// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "core/result.h"
#include "geometry/field/sample_particles.h"

namespace livegs::study {

// A box of cubes, each cut into five tetrahedra (the middle one regular), mirrored between neighbouring cubes
// so that faces match.
struct TetrahedralBox {
  Eigen::Vector3d min_m;
  double cell_width_m = 0.0;
  Eigen::Vector3i cells;
  std::vector<Eigen::Vector3d> nodes_m;
  std::vector<std::array<int, 4>> tetrahedra;  // positive volume

  // The cube that contains a point, and the local coordinates of the point, 0 to 1. Points outside belong to
  // the nearest cube.
  struct Place {
    std::array<int, 8> nodes;  // x fastest
    Eigen::Vector3d local;
    double weight(int corner) const;  // trilinear
  };
  Place find(const Eigen::Vector3d& point_m) const;
  int node_at(const Eigen::Vector3i& index) const {
    return index.x() + (cells.x() + 1) * (index.y() + (cells.y() + 1) * index.z());
  }
};

// Builds the box filled by the voxels of the particles. Fails if they leave gaps or an edge is not a multiple
// of the width.
Result<TetrahedralBox> make_tetrahedral_box(const ParticleSet& particles, double cell_width_m);

}  // namespace livegs::study
