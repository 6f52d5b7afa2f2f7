// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/field/unresolved_wall_cells.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "geometry/mesh/triangle_distance.h"

namespace livegs {
namespace {

// Search distance from a cell's centre to a face, in cells: half a cell beyond its corners.
constexpr double kFaceReach_cells = 0.5 * std::numbers::sqrt3 + 0.5;
constexpr double kOpposedCosine = -0.5;   // cosine of opposed normals; a wedge of 60 degrees
constexpr double kParallelCosine = -0.9;  // cosine of the normals of parallel faces of a wall
constexpr double kAlignedCosine = 0.75;   // cosine to the mean normal; normals within it are not opposed

struct NearFace {
  uint32_t cell;
  uint32_t triangle;
};

Eigen::Vector3d unit_normal(const TriangleMesh& mesh, uint32_t triangle) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  const Eigen::Vector3d normal =
      (mesh.vertices_m[b] - mesh.vertices_m[a]).cross(mesh.vertices_m[c] - mesh.vertices_m[a]);
  const double length = normal.norm();
  return length > 0.0 ? Eigen::Vector3d(normal / length) : Eigen::Vector3d::Zero();
}

Eigen::Vector3d foot(const TriangleMesh& mesh, uint32_t triangle, const Eigen::Vector3d& point_m) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  return closest_point_on_triangle(point_m, mesh.vertices_m[a], mesh.vertices_m[b], mesh.vertices_m[c]);
}

Eigen::Vector3d middle_m(const RegularGrid& grid, uint32_t cell) {
  const auto nx = static_cast<uint32_t>(grid.counts.x()), ny = static_cast<uint32_t>(grid.counts.y());
  const Eigen::Vector3d node(cell % nx, cell / nx % ny, cell / nx / ny);
  return grid.origin_m + grid.cell_m * (node.array() + 0.5).matrix();
}

std::vector<NearFace> near_faces(const TriangleMesh& mesh, const RegularGrid& grid) {
  const double reach2 = kFaceReach_cells * kFaceReach_cells * grid.cell_m * grid.cell_m;
  std::vector<NearFace> near;
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    Eigen::AlignedBox3d box;
    for (const uint32_t vertex : mesh.triangles[t]) box.extend(mesh.vertices_m[vertex]);
    const Eigen::Array3d low = (box.min() - grid.origin_m).array() / grid.cell_m - 0.5 - kFaceReach_cells;
    const Eigen::Array3d high = (box.max() - grid.origin_m).array() / grid.cell_m - 0.5 + kFaceReach_cells;
    const Eigen::Array3i begin = low.ceil().cast<int>().max(0);
    const Eigen::Array3i end = (high.floor().cast<int>() + 1).min(grid.counts.array() - 1);
    for (int k = begin.z(); k < end.z(); ++k) {
      for (int j = begin.y(); j < end.y(); ++j) {
        for (int i = begin.x(); i < end.x(); ++i) {
          const Eigen::Vector3d middle = grid.point_m(i, j, k).array() + 0.5 * grid.cell_m;
          if ((foot(mesh, t, middle) - middle).squaredNorm() > reach2) continue;
          near.push_back({static_cast<uint32_t>(grid.index(i, j, k)), t});
        }
      }
    }
  }
  std::sort(near.begin(), near.end(), [](const NearFace& a, const NearFace& b) {
    return a.cell != b.cell ? a.cell < b.cell : a.triangle < b.triangle;
  });
  return near;
}

class Walls {
 public:
  explicit Walls(const TriangleMesh& mesh) : mesh_(mesh) {
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t) normals_.push_back(unit_normal(mesh, t));
  }

  bool within(std::span<const NearFace> faces, const Eigen::Vector3d& middle_m) {
    if (one_way(faces)) return false;
    feet_.clear();
    for (const NearFace& face : faces) feet_.push_back(foot(mesh_, face.triangle, middle_m));
    bool thin = false;
    for (size_t i = 0; i < faces.size(); ++i) {
      const Eigen::Vector3d& normal = normals_[faces[i].triangle];
      for (size_t k = 0; k < i; ++k) {
        const double cosine = normal.dot(normals_[faces[k].triangle]);
        if (cosine > kOpposedCosine) continue;
        const double through_m = normal.dot(feet_[i] - feet_[k]);
        if (through_m < 0.0) continue;  // a gap, not a wall
        thin = true;
        if (cosine < kParallelCosine) thinnest_m_ = std::min(thinnest_m_, through_m);
      }
    }
    return thin;
  }

  double thinnest_m() const { return thinnest_m_; }

 private:
  bool one_way(std::span<const NearFace> faces) const {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const NearFace& face : faces) mean += normals_[face.triangle];
    const double length = mean.norm();
    return std::all_of(faces.begin(), faces.end(), [&](const NearFace& face) {
      return normals_[face.triangle].dot(mean) > kAlignedCosine * length;
    });
  }

  const TriangleMesh& mesh_;
  std::vector<Eigen::Vector3d> normals_;
  std::vector<Eigen::Vector3d> feet_;
  double thinnest_m_ = INFINITY;
};

}  // namespace

UnresolvedWallCells unresolved_wall_cells(const TriangleMesh& mesh, const RegularGrid& grid) {
  const std::vector<NearFace> near = near_faces(mesh, grid);
  Walls walls(mesh);
  UnresolvedWallCells cells;
  for (size_t begin = 0, end = 0; begin < near.size(); begin = end) {
    const uint32_t cell = near[begin].cell;
    while (end < near.size() && near[end].cell == cell) ++end;
    if (!walls.within(std::span(near).subspan(begin, end - begin), middle_m(grid, cell))) continue;
    if (cells.is_thin.empty()) cells.is_thin.assign(grid.size(), 0);
    cells.is_thin[cell] = 1;
  }
  cells.thinnest_m = walls.thinnest_m();
  return cells;
}

}  // namespace livegs
