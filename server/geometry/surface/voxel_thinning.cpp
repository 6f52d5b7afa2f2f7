// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/surface/voxel_thinning.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <tuple>

#include "core/percentile.h"

namespace livegs {

std::vector<Eigen::Vector3d> thin_by_voxels(std::span<const Eigen::Vector3d> points, double voxel,
                                            double least_share) {
  struct Candidate {
    uint64_t voxel_key;
    float distance2;  // from the voxel's centre, in voxels
    uint32_t point;
  };
  std::vector<Candidate> candidates;
  candidates.reserve(points.size());
  for (uint32_t p = 0; p < points.size(); ++p) {
    const Eigen::Array3d place = points[p].array() / voxel;
    const Eigen::Array3d cell = place.floor();
    const auto part = [&](int axis) {
      return static_cast<uint64_t>(static_cast<int64_t>(cell[axis]) + (1 << 20));
    };
    const auto distance2 = static_cast<float>((place - cell - 0.5).matrix().squaredNorm());
    candidates.push_back({part(0) << 42 | part(1) << 21 | part(2), distance2, p});
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return std::tie(a.voxel_key, a.distance2, a.point) < std::tie(b.voxel_key, b.distance2, b.point);
  });
  struct Occupied {
    uint32_t point;
    size_t count;
  };
  std::vector<Occupied> voxels;
  for (size_t c = 0; c < candidates.size(); ++c) {
    if (c == 0 || candidates[c].voxel_key != candidates[c - 1].voxel_key)
      voxels.push_back({candidates[c].point, 0});
    ++voxels.back().count;
  }
  double least_count = 0.0;
  if (least_share > 0.0 && !voxels.empty()) {
    std::vector<size_t> counts;
    for (const Occupied& one : voxels) counts.push_back(one.count);
    least_count = least_share * static_cast<double>(percentile(std::move(counts), 0.5));
  }
  std::vector<uint32_t> kept;
  for (const Occupied& one : voxels) {
    if (static_cast<double>(one.count) >= least_count) kept.push_back(one.point);
  }
  std::sort(kept.begin(), kept.end());
  std::vector<Eigen::Vector3d> thinned;
  thinned.reserve(kept.size());
  for (uint32_t p : kept) thinned.push_back(points[p]);
  return thinned;
}

}  // namespace livegs
