// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/harness/tetrahedral_box.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace livegs::study {

using Eigen::Vector3d;
using Eigen::Vector3i;

double TetrahedralBox::Place::weight(int corner) const {
  double weight = 1.0;
  for (int d = 0; d < 3; ++d) weight *= corner >> d & 1 ? local[d] : 1.0 - local[d];
  return weight;
}

TetrahedralBox::Place TetrahedralBox::find(const Vector3d& point_m) const {
  Place place;
  Vector3i cube;
  for (int d = 0; d < 3; ++d) {
    const double along = (point_m[d] - min_m[d]) / cell_width_m;
    cube[d] = std::clamp(static_cast<int>(std::floor(along)), 0, cells[d] - 1);
    place.local[d] = along - cube[d];
  }
  for (int c = 0; c < 8; ++c) place.nodes[c] = node_at(cube + Vector3i(c & 1, c >> 1 & 1, c >> 2));
  return place;
}

Result<TetrahedralBox> make_tetrahedral_box(const ParticleSet& particles, double cell_width_m) {
  const double spacing = particles.spacing_m;
  Vector3d low = particles.positions_m.front(), high = low;
  for (const Vector3d& p : particles.positions_m) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  TetrahedralBox box;
  box.min_m = low - Vector3d::Constant(0.5 * spacing);
  const Vector3d size = high - low + Vector3d::Constant(spacing);
  double volume = 0.0;
  for (const double v : particles.volumes_m3) volume += v;
  if (std::abs(volume / size.prod() - 1.0) > 1e-6)
    return unsupported("tetrahedral box: the particles do not fill a box");
  box.cell_width_m = cell_width_m;
  box.cells = (size / cell_width_m).array().round().cast<int>();
  if ((box.cells.cast<double>() * cell_width_m - size).norm() > 1e-6 * size.norm()) {
    return unsupported("tetrahedral box: the edges are not multiples of " + std::to_string(cell_width_m) +
                       " m");
  }

  for (int k = 0; k <= box.cells.z(); ++k) {
    for (int j = 0; j <= box.cells.y(); ++j) {
      for (int i = 0; i <= box.cells.x(); ++i)
        box.nodes_m.push_back(box.min_m + cell_width_m * Vector3d(i, j, k));
    }
  }
  // The tetrahedra at the even corners and the middle one. Odd cubes are mirrored along x, which swaps the
  // lowest bit of the corners.
  constexpr std::array<std::array<int, 4>, 5> kCut{
      {{0, 1, 2, 4}, {3, 2, 1, 7}, {5, 4, 7, 1}, {6, 7, 4, 2}, {1, 2, 4, 7}}};
  for (int k = 0; k < box.cells.z(); ++k) {
    for (int j = 0; j < box.cells.y(); ++j) {
      for (int i = 0; i < box.cells.x(); ++i) {
        const int mirror = (i + j + k) & 1;
        for (const auto& corners : kCut) {
          std::array<int, 4> tetrahedron;
          for (int v = 0; v < 4; ++v) {
            const int c = corners[v] ^ mirror;
            tetrahedron[v] = box.node_at(Vector3i(i, j, k) + Vector3i(c & 1, c >> 1 & 1, c >> 2));
          }
          const Vector3d& o = box.nodes_m[tetrahedron[0]];
          const double six_volumes = (box.nodes_m[tetrahedron[1]] - o)
                                         .cross(box.nodes_m[tetrahedron[2]] - o)
                                         .dot(box.nodes_m[tetrahedron[3]] - o);
          if (six_volumes < 0.0) std::swap(tetrahedron[2], tetrahedron[3]);
          box.tetrahedra.push_back(tetrahedron);
        }
      }
    }
  }
  return box;
}

}  // namespace livegs::study
