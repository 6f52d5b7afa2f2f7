// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <optional>

#include "physics/collider.h"

namespace livegs {

// First contact of a moving sphere (or point: radius 0) with a surface.
struct SphereCastHit {
  double displacement_m = 0;  // distance travelled until contact
  double separation_m = 0;    // at the start, along the normal of the contact
  Eigen::Vector3d normal;
};

// A point is swept if its displacement per step exceeds this fraction of the other body's thickness: the
// thinnest wall of a collider, or the smallest side of a rigid body's box. Larger: points tunnel. Smaller:
// more time.
inline constexpr double kMaxUnsweptPart = 0.2;

// Conservative advancement along `displacement_m`. `sample` returns the surface at a point; its distance must
// be a lower bound of the true one. Surfaces that the sphere moves away from or along are ignored.
template <class Sample>
std::optional<SphereCastHit> cast_sphere(const Sample& sample, const Eigen::Vector3d& start_m,
                                         const Eigen::Vector3d& displacement_m, double radius_m,
                                         double tolerance_m) {
  const int most = 64;  // a grazing path may stay unresolved until the next substep
  const double length = displacement_m.norm();
  if (!(length > 0.0)) return std::nullopt;
  const Eigen::Vector3d direction = displacement_m / length;
  double travelled = 0.0;
  for (int march = 0; march < most && travelled <= length; ++march) {
    const SurfaceSample surface = sample(Eigen::Vector3d(start_m + travelled * direction));
    const double gap = surface.distance_m - radius_m;
    const double slope = surface.normal.dot(direction);
    if (gap < tolerance_m && slope < -1e-3)
      return SphereCastHit{travelled, gap - travelled * slope, surface.normal};
    travelled += std::max({gap, tolerance_m, length / most * (gap < tolerance_m ? 1.0 : 0.0)});
  }
  return std::nullopt;
}

}  // namespace livegs
