// SPDX-License-Identifier: GPL-3.0-or-later
// voro++ (Rycroft 2009) uses absolute tolerances of 1e-11, so the input is scaled to a unit box.
#include "geometry/fracture/voronoi_neighbours.h"

#include <algorithm>
#include <cmath>
#include <voro++/voro++.hh>

namespace livegs {

std::vector<std::vector<uint32_t>> voronoi_neighbours(std::span<const Eigen::Vector3d> seeds_m,
                                                      const Eigen::AlignedBox3d& bounds_m) {
  Eigen::AlignedBox3d box = bounds_m;
  for (const auto& seed : seeds_m) box.extend(seed);
  const double scale = 1.0 / box.diagonal().norm();
  // A margin keeps seeds off the walls.
  const Eigen::Vector3d half = (0.5 * scale * box.sizes()).array() + 0.01;
  const int blocks = std::max(1, static_cast<int>(std::cbrt(static_cast<double>(seeds_m.size()) / 5.0)));
  voro::container container(-half.x(), half.x(), -half.y(), half.y(), -half.z(), half.z(), blocks, blocks,
                            blocks, false, false, false, 8);
  for (size_t s = 0; s < seeds_m.size(); ++s) {
    const Eigen::Vector3d p = scale * (seeds_m[s] - box.center());
    container.put(static_cast<int>(s), p.x(), p.y(), p.z());
  }
  std::vector<std::vector<uint32_t>> neighbours(seeds_m.size());
  voro::c_loop_all loop(container);
  voro::voronoicell_neighbor cell;
  std::vector<int> ids;
  if (loop.start()) {
    do {
      if (!container.compute_cell(cell, loop)) continue;
      const auto seed = static_cast<uint32_t>(loop.pid());
      cell.neighbors(ids);
      for (int id : ids) {
        if (id < 0) continue;  // a wall
        neighbours[seed].push_back(static_cast<uint32_t>(id));
        // Symmetric even if rounding removes a tiny face on one side.
        neighbours[static_cast<uint32_t>(id)].push_back(seed);
      }
    } while (loop.inc());
  }
  for (uint32_t s = 0; s < neighbours.size(); ++s) {
    auto& list = neighbours[s];
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    std::stable_sort(list.begin(), list.end(), [&](uint32_t a, uint32_t b) {
      return (seeds_m[a] - seeds_m[s]).squaredNorm() < (seeds_m[b] - seeds_m[s]).squaredNorm();
    });
  }
  return neighbours;
}

}  // namespace livegs
