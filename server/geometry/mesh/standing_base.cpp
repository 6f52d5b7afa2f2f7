// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/mesh/standing_base.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/mesh/planar_hull.h"

namespace livegs {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Relative to the height of the thing: steps between planes, the highest plane, and the height above a plane
// up to which points belong to its base. Larger: more uneven bases are accepted, more of the shape is
// changed.
constexpr double kPlaneStep = 0.005, kHighestPlane = 0.1, kBaseHeight = 0.02;
constexpr double kMaxWidening = 20.0;
// Least margin of the base over the largest one of all planes. A knot of haze below a heavy pot carries the
// pot too, but only just. Larger: higher planes are taken, and round bottoms lose more.
constexpr double kMinMarginShare = 0.25;

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

// Least signed distance from the edges of a hull; negative outside.
double inside_m(const std::vector<Vector2d>& hull, const Vector2d& point) {
  double least = INFINITY;
  for (size_t i = 0; i < hull.size(); ++i) {
    const Vector2d &from = hull[i], edge = hull[(i + 1) % hull.size()] - from;
    least = std::min(least, cross(edge, point - from) / edge.norm());
  }
  return least;
}

Vector2d on_floor(const Vector3d& point) { return {point.x(), point.z()}; }

}  // namespace

std::optional<StandingBase> standing_base(std::span<const Vector3d> points_m,
                                          const Vector3d& centre_of_mass_m) {
  double lowest = INFINITY, highest = -INFINITY;
  for (const Vector3d& point : points_m) {
    lowest = std::min(lowest, point.y());
    highest = std::max(highest, point.y());
  }
  const double height = highest - lowest;
  if (!(height > 0.0)) return std::nullopt;
  const Vector2d centre = on_floor(centre_of_mass_m);
  struct Plane {
    StandingBase base;
    std::vector<Vector2d> hull;
  };
  std::vector<Plane> planes;
  for (double share = 0.0; share <= kHighestPlane; share += kPlaneStep) {
    const double plane = lowest + share * height;
    std::vector<Vector2d> base;
    for (const Vector3d& point : points_m) {
      if (point.y() <= plane + kBaseHeight * height) base.push_back(on_floor(point));
    }
    std::vector<Vector2d> hull = planar_hull(std::move(base));
    if (hull.empty() || centre_of_mass_m.y() <= plane) continue;
    const double margin = inside_m(hull, centre) / (centre_of_mass_m.y() - plane);
    planes.push_back({StandingBase{plane, lowest, margin, 1.0}, std::move(hull)});
  }
  if (planes.empty()) return std::nullopt;
  const Plane& widest = *std::max_element(planes.begin(), planes.end(), [](const Plane& a, const Plane& b) {
    return a.base.margin < b.base.margin;
  });
  const double least = std::max(kStandingMargin, kMinMarginShare * widest.base.margin);
  for (const Plane& plane : planes) {
    if (plane.base.margin >= least) return plane.base;
  }
  std::optional<StandingBase> best = widest.base;
  const std::vector<Vector2d>& best_hull = widest.hull;
  // Points of the hull move away from the centre of mass; a base that it lies outside of is also moved under
  // it.
  const double needed_m = kStandingMargin * (centre_of_mass_m.y() - best->plane_m);
  Vector2d middle = Vector2d::Zero();
  for (const Vector2d& point : best_hull) middle += point / static_cast<double>(best_hull.size());
  const double own_m = inside_m(best_hull, middle);
  best->widened = std::clamp(own_m > 0.0 ? needed_m / own_m : kMaxWidening, 1.0, kMaxWidening);
  best->middle_m = middle;
  return best;
}

void flatten_base(std::span<Vector3d> points_m, const StandingBase& base, const Vector3d& centre_of_mass_m) {
  double highest = -INFINITY;
  for (const Vector3d& point : points_m) highest = std::max(highest, point.y());
  const double upto_m = base.plane_m + kBaseHeight * (highest - base.lowest_m);
  const bool move = base.margin < kStandingMargin;
  for (Vector3d& point : points_m) {
    if (point.y() > upto_m) continue;
    point.y() = base.plane_m;
    if (!move) continue;
    point.x() = centre_of_mass_m.x() + base.widened * (point.x() - base.middle_m.x());
    point.z() = centre_of_mass_m.z() + base.widened * (point.z() - base.middle_m.y());
  }
}

}  // namespace livegs
