// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "geometry/mesh/triangle_tree.h"
#include "geometry/triangle_mesh.h"

namespace livegs {

// Signed distance to a closed mesh on a regular grid, negative inside, trilinear between nodes, in the mesh's
// frame. Immutable after building; any thread may sample.
class DistanceField {
 public:
  // What is thinner than some two cells a grid shows too thin, or not at all: there the distance to the
  // triangles themselves may be asked for, which takes about a microsecond a sample.
  enum class Thin { ByTheGrid, Exact };
  // cell_m: edge of a grid cell, widened where it would make more than 8 million nodes; margin_m: how far the
  // grid reaches beyond the mesh. Nodes within a cell of the surface hold the exact distance, those farther
  // out the distance to some triangle near the nearest: too large by at most a tenth of a cell. Precondition:
  // at least one triangle.
  DistanceField(const TriangleMesh& mesh, double cell_m, double margin_m, Thin thin = Thin::ByTheGrid);

  struct Sample {
    double distance_m;
    Eigen::Vector3d gradient;  // unit where the distance is smooth
  };
  // Outside the grid: the distance at the nearest grid point plus the way to it (never less than the true
  // distance minus one cell).
  Sample sample(const Eigen::Vector3d& point_m) const;

  double cell_m() const { return cell_m_; }
  // What a point can jump over without being seen inside: about the thinnest wall, at most two cells.
  double thinnest_m() const { return thinnest_m_; }
  const Eigen::Vector3i& node_counts() const { return counts_; }

 private:
  double cell_m_;
  Eigen::Vector3d origin_m_;
  Eigen::Vector3i counts_;
  std::vector<float> distances_m_;
  // Where the triangles are asked, by the cell's lowest node; empty: nowhere.
  std::vector<uint8_t> is_thin_;
  std::unique_ptr<const TriangleTree> triangles_;
  double thinnest_m_;
};

}  // namespace livegs
