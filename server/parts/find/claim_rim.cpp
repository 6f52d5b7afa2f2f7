// SPDX-License-Identifier: GPL-3.0-or-later
#include "parts/find/claim_rim.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/parallel_for.h"
#include "parts/graph/kernel_tree.h"

namespace livegs {
namespace {

constexpr double kRimHeight_voxels = 0.6;  // least height above a plane of the room
constexpr double kRimDeviations = 4.0;
constexpr double kRimStep_voxels = 1.5;  // to a kernel of the thing, in each round
constexpr int kRimRounds = 4;
constexpr size_t kRimNeighbours = 8;  // whose mean colour is compared
constexpr float kRimColour = 0.15f;   // distance of colours in 0..1

bool off_planes(const RoomParts& found, const Eigen::Vector3d& p) {
  const auto off = [&](const RoomPlane& plane) {
    return plane.height_m(p) >
           std::max(kRimHeight_voxels * found.voxel_m, kRimDeviations * plane.deviation_m);
  };
  bool over = false;
  for (const RoomPlane& plane : found.planes.supports) {
    if (!plane.region.contains(p)) continue;
    if (std::abs(plane.height_m(p)) < found.voxel_m && !off(plane)) return false;
    over = over || off(plane);
  }
  return over && std::all_of(found.planes.walls.begin(), found.planes.walls.end(), off);
}

}  // namespace

void claim_rim(const GaussianAsset& asset, RoomParts& found) {
  const auto step_m = static_cast<float>(kRimStep_voxels * found.voxel_m);
  const auto colour = [&](size_t k) -> Eigen::Vector3f {
    return Eigen::Vector3f::Constant(0.5f) + kShBand0 * asset.sh_dc[k];
  };
  std::vector<uint32_t> open;
  for (uint32_t k = 0; k < asset.size(); ++k)
    if (found.label[k] == kRoomLabel && off_planes(found, asset.positions[k].cast<double>()))
      open.push_back(k);
  for (int round = 0; round < kRimRounds && !open.empty(); ++round) {
    std::vector<Eigen::Vector3f> points;
    std::vector<uint32_t> index;
    for (uint32_t k = 0; k < asset.size(); ++k)
      if (found.label[k] != kRoomLabel) points.push_back(asset.positions[k]), index.push_back(k);
    if (points.empty()) return;
    const KernelTree tree(points);
    std::vector<uint16_t> claimed(open.size(), kRoomLabel);
    parallel_for(open.size(), 256, [&](size_t begin, size_t end) {
      std::vector<KernelTree::Neighbour> nearest;
      for (size_t i = begin; i < end; ++i) {
        tree.nearest(asset.positions[open[i]], 1, nearest, step_m);
        if (nearest.empty()) continue;
        tree.nearest(asset.positions[open[i]], kRimNeighbours, nearest);
        const uint16_t label = found.label[index[nearest[0].index]];
        Eigen::Vector3f mean = Eigen::Vector3f::Zero();
        float count = 0;
        for (const auto& n : nearest)
          if (found.label[index[n.index]] == label) mean += colour(index[n.index]), ++count;
        if ((colour(open[i]) - mean / count).norm() < kRimColour) claimed[i] = label;
      }
    });
    std::vector<uint32_t> left;
    for (size_t i = 0; i < open.size(); ++i) {
      if (claimed[i] == kRoomLabel)
        left.push_back(open[i]);
      else
        found.label[open[i]] = claimed[i];
    }
    if (left.size() == open.size()) return;
    open = std::move(left);
  }
}

}  // namespace livegs
