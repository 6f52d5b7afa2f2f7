// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/mesh/planar_hull.h"

#include <algorithm>

namespace livegs {
namespace {

using Eigen::Vector2d;

// Positive if a, b and c turn left.
double turn(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

}  // namespace

std::vector<Vector2d> planar_hull(std::vector<Vector2d> points) {
  std::sort(points.begin(), points.end(), [](const Vector2d& a, const Vector2d& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return {};
  std::vector<Vector2d> hull;
  const auto add = [&](const Vector2d& point, size_t kept) {
    while (hull.size() >= kept + 2 && turn(hull[hull.size() - 2], hull.back(), point) <= 0.0) hull.pop_back();
    hull.push_back(point);
  };
  for (const Vector2d& point : points) add(point, 0);
  const size_t lower = hull.size() - 1;
  for (size_t i = points.size() - 1; i-- > 0;) add(points[i], lower);
  hull.pop_back();
  if (hull.size() < 3) return {};
  return hull;
}

}  // namespace livegs
