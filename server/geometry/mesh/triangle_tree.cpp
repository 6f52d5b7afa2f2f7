// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/mesh/triangle_tree.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/mesh/triangle_distance.h"

namespace livegs {
namespace {

constexpr uint32_t kLeafTriangles = 4;
// Relative distance below which two projections count as the same point.
constexpr double kFootTolerance = 1e-9;

double squared_distance(const Eigen::Vector3d& point, const Eigen::Vector3d& min,
                        const Eigen::Vector3d& max) {
  return (point - point.cwiseMax(min).cwiseMin(max)).squaredNorm();
}

}  // namespace

TriangleTree::TriangleTree(const TriangleMesh& mesh) {
  triangles_.reserve(mesh.triangles.size());
  for (uint32_t index = 0; index < mesh.triangles.size(); ++index) {
    const auto& [a, b, c] = mesh.triangles[index];
    Triangle triangle{{mesh.vertices_m[a], mesh.vertices_m[b], mesh.vertices_m[c]}, {}, index};
    const auto& [p, q, r] = triangle.corner_m;
    const Eigen::Vector3d normal = (q - p).cross(r - p);
    const double length = normal.norm();
    if (!(length > 0.0)) continue;
    triangle.normal = normal / length;
    triangles_.push_back(triangle);
  }
  if (!triangles_.empty()) add_box(0, static_cast<uint32_t>(triangles_.size()));
}

void TriangleTree::add_box(uint32_t begin, uint32_t end) {
  Eigen::AlignedBox3d bounds;
  for (uint32_t i = begin; i < end; ++i) {
    for (const Eigen::Vector3d& corner : triangles_[i].corner_m) bounds.extend(corner);
  }
  const size_t own = boxes_.size();
  boxes_.push_back({bounds.min(), bounds.max(), begin, end, 0});
  if (end - begin <= kLeafTriangles) return;
  Eigen::Index axis;
  bounds.sizes().maxCoeff(&axis);
  const uint32_t middle = begin + (end - begin) / 2;
  const auto place = [axis](const Triangle& one) {
    return one.corner_m[0][axis] + one.corner_m[1][axis] + one.corner_m[2][axis];
  };
  std::stable_sort(triangles_.begin() + begin, triangles_.begin() + end,
                   [&](const Triangle& a, const Triangle& b) { return place(a) < place(b); });
  add_box(begin, middle);
  boxes_[own].second = static_cast<uint32_t>(boxes_.size());
  add_box(middle, end);
}

TriangleTree::Nearest TriangleTree::nearest(const Eigen::Vector3d& point_m) const {
  Nearest best{INFINITY, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitY(), 0};
  double least2 = INFINITY, squarest = -1.0;
  std::array<uint32_t, 64> waiting;  // never deeper than the logarithm of the number of triangles
  size_t count = 0;
  if (!boxes_.empty()) waiting[count++] = 0;
  while (count > 0) {
    const uint32_t index = waiting[--count];
    const Box& box = boxes_[index];
    if (squared_distance(point_m, box.min_m, box.max_m) > least2 * (1.0 + 4.0 * kFootTolerance)) continue;
    if (box.second != 0) {
      const Box &first = boxes_[index + 1], &second = boxes_[box.second];
      const bool swap = squared_distance(point_m, second.min_m, second.max_m) <
                        squared_distance(point_m, first.min_m, first.max_m);
      waiting[count++] = swap ? index + 1 : box.second;
      waiting[count++] = swap ? box.second : index + 1;
      continue;
    }
    for (uint32_t i = box.begin; i < box.end; ++i) {
      const Triangle& triangle = triangles_[i];
      const Eigen::Vector3d foot = closest_point_on_triangle(point_m, triangle.corner_m[0],
                                                             triangle.corner_m[1], triangle.corner_m[2]);
      const Eigen::Vector3d away = point_m - foot;
      const double squared = away.squaredNorm();
      if (squared > least2 * (1.0 + 2.0 * kFootTolerance)) continue;
      const double square = std::abs(triangle.normal.dot(away));
      const bool same = squared >= least2 * (1.0 - 2.0 * kFootTolerance);
      if (!same || square > squarest) {
        best.foot_m = foot;
        best.normal = triangle.normal;
        best.triangle = triangle.index;
        squarest = square;
      }
      least2 = std::min(least2, squared);
    }
  }
  best.distance_m = std::sqrt(least2);
  return best;
}

}  // namespace livegs
