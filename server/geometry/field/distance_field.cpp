// SPDX-License-Identifier: GPL-3.0-or-later
// Nodes within one cell of the surface store the exact distance to their nearest triangle. Farther nodes are
// filled by closest-triangle propagation (Bridson's level-set construction) in eight passes over the grid.
// The result is the distance to some triangle, so it is never too small. The sign comes from scanlines, which
// are robust against bad normals.
#include "geometry/field/distance_field.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/assert.h"
#include "geometry/field/inside_grid.h"
#include "geometry/field/regular_grid.h"
#include "geometry/field/unresolved_wall_cells.h"
#include "geometry/mesh/mesh_topology.h"
#include "geometry/mesh/triangle_distance.h"

namespace livegs {
namespace {

// Minimum thickness in cells. A sheet without thickness has no inside.
constexpr double kMinThickness = 0.01;

class NearestTriangles {
 public:
  NearestTriangles(const TriangleMesh& mesh, const RegularGrid& grid)
      : mesh_(mesh),
        grid_(grid),
        triangle_(grid.size(), -1),
        distance2_(grid.size(), std::numeric_limits<float>::max()),
        changed_(grid.size(), kBand) {
    for (int32_t t = 0; t < static_cast<int32_t>(mesh.triangles.size()); ++t) fill_band(t);
    for (int direction = 0; direction < 8; ++direction) sweep(direction);
  }

  float distance_m(size_t node) const { return std::sqrt(distance2_[node]); }

 private:
  void offer(size_t node, const Eigen::Vector3d& point_m, int32_t triangle) {
    const auto& [a, b, c] = mesh_.triangles[triangle];
    const Eigen::Vector3d foot =
        closest_point_on_triangle(point_m, mesh_.vertices_m[a], mesh_.vertices_m[b], mesh_.vertices_m[c]);
    const auto distance2 = static_cast<float>((foot - point_m).squaredNorm());
    if (distance2 < distance2_[node]) {
      distance2_[node] = distance2;
      triangle_[node] = triangle;
      changed_[node] = pass_;
    }
  }

  // Visits all nodes that may be within one cell of the triangle.
  void fill_band(int32_t triangle) {
    Eigen::AlignedBox3d box;
    for (uint32_t vertex : mesh_.triangles[triangle]) box.extend(mesh_.vertices_m[vertex]);
    const Eigen::Array3d low = (box.min() - grid_.origin_m).array() / grid_.cell_m - 1.0;
    const Eigen::Array3d high = (box.max() - grid_.origin_m).array() / grid_.cell_m + 1.0;
    const Eigen::Array3i begin = low.ceil().cast<int>().max(0);
    const Eigen::Array3i end = (high.floor().cast<int>() + 1).min(grid_.counts.array());
    for (int k = begin.z(); k < end.z(); ++k) {
      for (int j = begin.y(); j < end.y(); ++j) {
        for (int i = begin.x(); i < end.x(); ++i)
          offer(grid_.index(i, j, k), grid_.point_m(i, j, k), triangle);
      }
    }
  }

  // Runs one pass from a corner of the grid to the opposite one; bits of `direction` reverse the axes.
  void sweep(int direction) {
    pass_ = static_cast<int8_t>(direction);
    int8_t before[8];  // last pass that took the triangles of the same neighbours; kBand - 1: none
    for (int back = 1; back < 8; ++back) {
      before[back] = static_cast<int8_t>(direction - 1);
      while (before[back] >= 0 && ((before[back] ^ direction) & back)) --before[back];
      if (before[back] < 0) before[back] = kBand - 1;
    }
    const Eigen::Vector3i step(direction & 1 ? -1 : 1, direction & 2 ? -1 : 1, direction & 4 ? -1 : 1);
    const Eigen::Vector3i& counts = grid_.counts;
    const auto band2 = static_cast<float>(grid_.cell_m * grid_.cell_m);
    for (int c = 0; c < counts.z(); ++c) {
      const int k = step.z() > 0 ? c : counts.z() - 1 - c;
      for (int b = 0; b < counts.y(); ++b) {
        const int j = step.y() > 0 ? b : counts.y() - 1 - b;
        for (int a = 0; a < counts.x(); ++a) {
          const int i = step.x() > 0 ? a : counts.x() - 1 - a;
          const size_t node = grid_.index(i, j, k);
          if (distance2_[node] <= band2) continue;  // already exact
          const Eigen::Vector3d point_m = grid_.point_m(i, j, k);
          int32_t tried = triangle_[node];
          const auto take = [&](size_t neighbour, int8_t taken) {
            if (changed_[neighbour] <= taken) return;  // this node has tried its triangle
            const int32_t triangle = triangle_[neighbour];
            if (triangle < 0 || triangle == tried || triangle == triangle_[node]) return;
            tried = triangle;
            offer(node, point_m, triangle);
          };
          for (int back = 1; back < 8; ++back) {
            const int x = back & 1, y = back >> 1 & 1, z = back >> 2;
            if (a < x || b < y || c < z) continue;
            take(grid_.index(i - x * step.x(), j - y * step.y(), k - z * step.z()), before[back]);
          }
        }
      }
    }
  }

  const TriangleMesh& mesh_;
  const RegularGrid& grid_;
  static constexpr int8_t kBand = -1;
  std::vector<int32_t> triangle_;  // -1: not set
  std::vector<float> distance2_;
  std::vector<int8_t> changed_;  // pass that set the triangle; kBand: fill_band()
  int8_t pass_ = kBand;
};

}  // namespace

DistanceField::DistanceField(const TriangleMesh& mesh, double cell_m, double margin_m, Thin thin) {
  LIVEGS_ASSERT(!mesh.triangles.empty() && cell_m > 0.0 && margin_m >= 0.0);
  const Eigen::AlignedBox3d bounds = mesh_bounds_m(mesh);
  const Eigen::Vector3d size_m = bounds.sizes().array() + 2.0 * margin_m;
  RegularGrid grid;
  grid.cell_m = cell_m_ = affordable_cell_m(cell_m, size_m);
  grid.origin_m = origin_m_ = bounds.min().array() - margin_m;
  grid.counts = counts_ = ((size_m / cell_m_).array() - 1e-9).ceil().cast<int>().max(1) + 1;
  const NearestTriangles nearest(mesh, grid);
  const std::vector<uint8_t> inside = nodes_inside(mesh, grid);
  distances_m_.resize(grid.size());
  for (size_t node = 0; node < grid.size(); ++node) {
    distances_m_[node] = inside[node] ? -nearest.distance_m(node) : nearest.distance_m(node);
  }
  thinnest_m_ = 2.0 * cell_m_;
  if (thin == Thin::ByTheGrid) return;
  UnresolvedWallCells cells = unresolved_wall_cells(mesh, grid);
  if (cells.is_thin.empty()) return;
  is_thin_ = std::move(cells.is_thin);
  triangles_ = std::make_unique<const TriangleTree>(mesh);
  thinnest_m_ = std::clamp(cells.thinnest_m, kMinThickness * cell_m_, thinnest_m_);
}

DistanceField::Sample DistanceField::sample(const Eigen::Vector3d& point_m) const {
  const Eigen::Array3d top = (counts_.array() - 1).cast<double>();
  const Eigen::Array3d place = ((point_m - origin_m_) / cell_m_).array();
  const Eigen::Array3d clamped = place.max(0.0).min(top);
  // A NaN position has a valid index, since NaN has no value as an int; the resulting distance is NaN.
  const Eigen::Array3i node =
      clamped.isNaN().select(0.0, clamped).cast<int>().max(0).min(counts_.array() - 2);
  const Eigen::Array3d f = clamped - node.cast<double>();

  const size_t dy = counts_.x(), dz = dy * counts_.y();
  const size_t cell = node.x() + dy * node.y() + dz * node.z();
  const float* d = distances_m_.data() + cell;
  const double c000 = d[0], c100 = d[1], c010 = d[dy], c110 = d[dy + 1];
  const double c001 = d[dz], c101 = d[dz + 1], c011 = d[dz + dy], c111 = d[dz + dy + 1];
  const double gx = 1.0 - f.x(), gy = 1.0 - f.y(), gz = 1.0 - f.z();
  const double c00 = gx * c000 + f.x() * c100, c10 = gx * c010 + f.x() * c110;
  const double c01 = gx * c001 + f.x() * c101, c11 = gx * c011 + f.x() * c111;
  Sample sample;
  if (!is_thin_.empty() && is_thin_[cell] && (place == clamped).all()) {
    const TriangleTree::Nearest nearest = triangles_->nearest(point_m);
    const Eigen::Vector3d away = point_m - nearest.foot_m;
    // Where parts of a mesh overlap, a face inside another part is not a boundary.
    const bool buried =
        std::max({d[0], d[1], d[dy], d[dy + 1], d[dz], d[dz + 1], d[dz + dy], d[dz + dy + 1]}) < 0.0f;
    const double side = buried || nearest.normal.dot(away) < 0.0 ? -1.0 : 1.0;
    sample.distance_m = side * nearest.distance_m;
    sample.gradient = nearest.distance_m > 1e-6 * cell_m_ ? Eigen::Vector3d(side / nearest.distance_m * away)
                                                          : nearest.normal;
    return sample;
  }
  sample.distance_m = gz * (gy * c00 + f.y() * c10) + f.z() * (gy * c01 + f.y() * c11);
  sample.gradient.x() = gz * (gy * (c100 - c000) + f.y() * (c110 - c010)) +
                        f.z() * (gy * (c101 - c001) + f.y() * (c111 - c011));
  sample.gradient.y() = gz * (c10 - c00) + f.z() * (c11 - c01);
  sample.gradient.z() = gy * (c01 - c00) + f.y() * (c11 - c10);
  const double length = sample.gradient.norm();
  sample.gradient = length > 0.0 ? Eigen::Vector3d(sample.gradient / length) : Eigen::Vector3d::UnitY();

  const Eigen::Vector3d way_m = cell_m_ * (place - clamped).matrix();
  const double way_length_m = way_m.norm();
  if (way_length_m > 0.0) {
    // The surface lies about distance_m * gradient behind the grid's edge; the gradient points away from it.
    const Eigen::Vector3d from_surface = way_m + std::max(sample.distance_m, 0.0) * sample.gradient;
    if (from_surface.norm() > 0.0) sample.gradient = from_surface.normalized();
    sample.distance_m += way_length_m;
  }
  return sample;
}

}  // namespace livegs
