// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <optional>

#include "physics/collider.h"

namespace livegs {

// Where a moving sphere (or a point: radius 0) first meets a surface.
struct SphereCastHit {
  double displacement_m = 0;  // travelled until then
  double separation_m = 0;    // at the start, along the normal of the surface that is met
  Eigen::Vector3d normal;
};

// A point's displacement in a step is swept if it exceeds this part of the thickness of the other body: of a
// collider its thinnest wall, of a rigid body the smallest side of its box. Larger: points tunnel through.
// Smaller: more time.
inline constexpr double kMaxUnsweptPart = 0.2;

// Conservative advancement: marches along `displacement_m` by the distance that is certainly free. `sample`
// gives the signed distance at a point, never more than the true one. Surfaces that the sphere leaves or
// slides along are passed by.
template <class Sample>
std::optional<SphereCastHit> cast_sphere(const Sample& sample, const Eigen::Vector3d& start_m,
                                         const Eigen::Vector3d& displacement_m, double radius_m,
                                         double tolerance_m) {
  constexpr int kMaxMarches = 64;  // a grazing path may end unresolved: it is tried again in the next substep
  const double length = displacement_m.norm();
  if (!(length > 0.0)) return std::nullopt;
  const Eigen::Vector3d direction = displacement_m / length;
  double travelled = 0.0;
  for (int march = 0; march < kMaxMarches && travelled <= length; ++march) {
    const SurfaceSample surface = sample(Eigen::Vector3d(start_m + travelled * direction));
    const double gap = surface.distance_m - radius_m;
    const double slope = surface.normal.dot(direction);
    if (gap < tolerance_m && slope < -1e-3)
      return SphereCastHit{travelled, gap - travelled * slope, surface.normal};
    travelled += std::max({gap, tolerance_m, length / kMaxMarches * (gap < tolerance_m ? 1.0 : 0.0)});
  }
  return std::nullopt;
}

}  // namespace livegs
