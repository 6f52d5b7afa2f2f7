// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "parts/views/room_view.h"

namespace livegs {

inline constexpr uint32_t kNoVoxel = ~0u;

// Occupied cells of a cubic grid, found by hashing (Teschner et al. 2003).
class VoxelSet {
 public:
  struct Voxel {
    Eigen::Vector3i cell;
    Eigen::Vector3f position_m, normal, rgb;  // means of its points; the normal is unit or zero
    float normal_length = 0;  // of the mean normal before it is made unit: 1 on a flat surface
    uint32_t points = 0;
  };

  // Voxels with at least `min_points` of the chosen points. In the order of their cells.
  VoxelSet(std::span<const ViewPoint> points, std::span<const uint32_t> chosen, double edge_m,
           uint32_t min_points);

  size_t size() const { return voxels_.size(); }
  const Voxel& operator[](size_t i) const { return voxels_[i]; }
  double edge_m() const { return edge_m_; }
  Eigen::Vector3i cell_of(const Eigen::Vector3d& point_m) const {
    return (point_m / edge_m_).array().floor().cast<int>();
  }
  uint32_t at(const Eigen::Vector3i& cell) const;  // kNoVoxel if it is not occupied
  // Keeps the voxels with a nonzero mark.
  void keep(std::span<const uint8_t> marks);

 private:
  void index();

  double edge_m_;
  std::vector<Voxel> voxels_;
  std::vector<uint32_t> slots_;  // open addressing; kNoVoxel: free
};

// The 13 neighbours of a cell that come after it, of 26.
std::span<const Eigen::Vector3i> later_neighbours();

// Component of each voxel among the 26-connected ones; components are numbered by their first voxel.
std::vector<uint32_t> connected_voxels(const VoxelSet& voxels, size_t& component_count);

}  // namespace livegs
