// SPDX-License-Identifier: GPL-3.0-or-later
// Freeman and Shapira 1975: the smallest rectangle around a convex polygon has a side along one of its edges.
#include "geometry/mesh/smallest_box.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "geometry/mesh/mesh_topology.h"
#include "geometry/mesh/planar_hull.h"

namespace livegs {
namespace {

// Number of directions that are tried, largest faces first. More directions give slightly smaller boxes and
// cost more time.
constexpr size_t kMaxDirections = 48;
constexpr double kParallelCosineLimit = 0.999;  // cosine of 2.6 degrees

std::vector<Eigen::Vector3d> directions_of(const TriangleMesh& hull) {
  struct Direction {
    Eigen::Vector3d way;  // normal of the first such face
    double area_m2;
  };
  std::vector<Direction> faces;
  for (const auto& triangle : hull.triangles) {
    const Eigen::Vector3d& a = hull.vertices_m[triangle[0]];
    const Eigen::Vector3d area =
        0.5 * (hull.vertices_m[triangle[1]] - a).cross(hull.vertices_m[triangle[2]] - a);
    const double area_m2 = area.norm();
    if (!(area_m2 > 0)) continue;
    auto same = std::find_if(faces.begin(), faces.end(), [&](const Direction& face) {
      return std::abs(face.way.dot(area)) > kParallelCosineLimit * area_m2;
    });
    if (same == faces.end()) {
      faces.push_back({area / area_m2, area_m2});
    } else {
      same->area_m2 += area_m2;
    }
  }
  std::stable_sort(faces.begin(), faces.end(),
                   [](const Direction& a, const Direction& b) { return a.area_m2 > b.area_m2; });
  std::vector<Eigen::Vector3d> directions = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(),
                                             Eigen::Vector3d::UnitZ()};
  for (size_t i = 0; i < std::min(faces.size(), kMaxDirections); ++i) {
    directions.push_back(faces[i].way);
  }
  return directions;
}

Eigen::Vector2d smallest_rectangle(const std::vector<Eigen::Vector2d>& polygon) {
  Eigen::Vector2d best = Eigen::Vector2d::Constant(INFINITY);
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d along = (polygon[(i + 1) % polygon.size()] - polygon[i]).normalized();
    if (!along.allFinite() || along.isZero()) continue;
    const Eigen::Vector2d across(-along.y(), along.x());
    Eigen::Vector2d low = Eigen::Vector2d::Constant(INFINITY), high = -low;
    for (const Eigen::Vector2d& point : polygon) {
      const Eigen::Vector2d place(along.dot(point), across.dot(point));
      low = low.cwiseMin(place);
      high = high.cwiseMax(place);
    }
    if ((high - low).prod() < best.prod()) best = high - low;
  }
  return best;
}

}  // namespace

Eigen::Vector3d smallest_box_m(const TriangleMesh& hull) {
  Eigen::Vector3d best = mesh_bounds_m(hull).sizes();
  for (const Eigen::Vector3d& direction : directions_of(hull)) {
    const Eigen::Vector3d right = direction.unitOrthogonal(), up = direction.cross(right);
    std::vector<Eigen::Vector2d> shadow;
    double low = INFINITY, high = -INFINITY;
    for (const Eigen::Vector3d& vertex : hull.vertices_m) {
      shadow.emplace_back(right.dot(vertex), up.dot(vertex));
      low = std::min(low, direction.dot(vertex));
      high = std::max(high, direction.dot(vertex));
    }
    const Eigen::Vector2d rectangle = smallest_rectangle(planar_hull(std::move(shadow)));
    if (!rectangle.allFinite()) continue;
    const Eigen::Vector3d box(rectangle.x(), rectangle.y(), high - low);
    if (box.prod() < best.prod()) best = box;
  }
  std::sort(best.data(), best.data() + 3, std::greater<>());
  return best;
}

}  // namespace livegs
