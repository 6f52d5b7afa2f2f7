// SPDX-License-Identifier: GPL-3.0-or-later
#include "parts/find/voxel_set.h"

#include <algorithm>
#include <bit>

#include "core/disjoint_sets.h"

namespace livegs {
namespace {

// 21 bits per axis, biased, so that keys sort by x, y, z.
uint64_t key_of(const Eigen::Vector3i& cell) {
  const auto part = [](int value) {
    return static_cast<uint64_t>(std::clamp(value + (1 << 20), 0, (1 << 21) - 1));
  };
  return part(cell.x()) << 42 | part(cell.y()) << 21 | part(cell.z());
}

uint64_t scatter(uint64_t key) {
  key ^= key >> 31;
  key *= 0x9E3779B97F4A7C15ull;
  return key ^ key >> 29;
}

}  // namespace

VoxelSet::VoxelSet(std::span<const ViewPoint> points, std::span<const uint32_t> chosen, double edge_m,
                   uint32_t min_points)
    : edge_m_(edge_m) {
  std::vector<std::pair<uint64_t, uint32_t>> order;
  order.reserve(chosen.size());
  for (uint32_t i : chosen) order.emplace_back(key_of(cell_of(points[i].position_m.cast<double>())), i);
  std::sort(order.begin(), order.end());
  for (size_t begin = 0, end; begin < order.size(); begin = end) {
    end = begin;
    while (end < order.size() && order[end].first == order[begin].first) ++end;
    if (end - begin < min_points) continue;
    Voxel voxel{cell_of(points[order[begin].second].position_m.cast<double>()),
                Eigen::Vector3f::Zero(),
                Eigen::Vector3f::Zero(),
                Eigen::Vector3f::Zero(),
                0.0f,
                static_cast<uint32_t>(end - begin)};
    for (size_t i = begin; i < end; ++i) {
      const ViewPoint& point = points[order[i].second];
      voxel.position_m += point.position_m;
      voxel.normal += point.normal;
      voxel.rgb += point.rgb;
    }
    voxel.position_m /= static_cast<float>(voxel.points);
    voxel.rgb /= static_cast<float>(voxel.points);
    voxel.normal_length = voxel.normal.norm() / static_cast<float>(voxel.points);
    if (voxel.normal_length > 0) voxel.normal.normalize();
    voxels_.push_back(voxel);
  }
  index();
}

void VoxelSet::index() {
  slots_.assign(std::bit_ceil(std::max<size_t>(8, 2 * voxels_.size())), kNoVoxel);
  const size_t mask = slots_.size() - 1;
  for (uint32_t i = 0; i < voxels_.size(); ++i) {
    size_t slot = scatter(key_of(voxels_[i].cell)) & mask;
    while (slots_[slot] != kNoVoxel) slot = (slot + 1) & mask;
    slots_[slot] = i;
  }
}

uint32_t VoxelSet::at(const Eigen::Vector3i& cell) const {
  const size_t mask = slots_.size() - 1;
  for (size_t slot = scatter(key_of(cell)) & mask; slots_[slot] != kNoVoxel; slot = (slot + 1) & mask)
    if (voxels_[slots_[slot]].cell == cell) return slots_[slot];
  return kNoVoxel;
}

void VoxelSet::keep(std::span<const uint8_t> marks) {
  size_t kept = 0;
  for (size_t i = 0; i < voxels_.size(); ++i)
    if (marks[i]) voxels_[kept++] = voxels_[i];
  voxels_.resize(kept);
  index();
}

std::span<const Eigen::Vector3i> later_neighbours() {
  static const std::vector<Eigen::Vector3i> steps = [] {
    std::vector<Eigen::Vector3i> later;
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z)
          if (x > 0 || (x == 0 && (y > 0 || (y == 0 && z > 0)))) later.emplace_back(x, y, z);
    return later;
  }();
  return steps;
}

std::vector<uint32_t> connected_voxels(const VoxelSet& voxels, size_t& component_count) {
  DisjointSets sets(voxels.size());
  for (uint32_t i = 0; i < voxels.size(); ++i)
    for (const Eigen::Vector3i& step : later_neighbours())
      if (const uint32_t other = voxels.at(voxels[i].cell + step); other != kNoVoxel) sets.join(i, other);
  std::vector<uint32_t> component(voxels.size());
  component_count = 0;
  for (uint32_t i = 0; i < voxels.size(); ++i) {
    const uint32_t root = sets.find(i);
    component[i] = root == i ? static_cast<uint32_t>(component_count++) : component[root];
  }
  return component;
}

}  // namespace livegs
