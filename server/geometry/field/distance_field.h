// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "geometry/mesh/triangle_tree.h"
#include "geometry/triangle_mesh.h"

namespace livegs {

// Signed distance to a closed mesh on a regular grid, metres, negative inside. Trilinear between nodes, in
// the mesh's frame. Immutable after construction; any thread may sample.
class DistanceField {
 public:
  // A grid underestimates or misses walls thinner than about two cells. Exact uses the distance to the
  // triangles there, at about a microsecond per sample.
  enum class Thin { ByTheGrid, Exact };
  // cell_m: edge of a grid cell, enlarged if the grid would exceed 8 million nodes.
  // margin_m: distance that the grid extends beyond the mesh.
  // Nodes within a cell of the surface store the exact distance. Farther nodes are too large by at most a
  // tenth of a cell. Precondition: at least one triangle.
  DistanceField(const TriangleMesh& mesh, double cell_m, double margin_m, Thin thin = Thin::ByTheGrid);

  struct Sample {
    double distance_m;
    Eigen::Vector3d gradient;  // unit length where the distance is smooth
  };
  // Outside the grid, returns the distance at the nearest grid point plus the distance to that point. The
  // result is never less than the true distance minus one cell.
  Sample sample(const Eigen::Vector3d& point_m) const;

  double cell_m() const { return cell_m_; }
  // Maximum safe step of a moving point: about the thinnest wall, at most two cells.
  double thinnest_m() const { return thinnest_m_; }
  const Eigen::Vector3i& node_counts() const { return counts_; }

 private:
  double cell_m_;
  Eigen::Vector3d origin_m_;
  Eigen::Vector3i counts_;
  std::vector<float> distances_m_;
  // Cells that use the exact triangle distance, by the cell's lowest node; empty: none.
  std::vector<uint8_t> is_thin_;
  std::unique_ptr<const TriangleTree> triangles_;
  double thinnest_m_;
};

}  // namespace livegs
