// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "geometry/triangle_mesh.h"

// The flat base of a captured object, on which it stands. A capture shows no underside. The captured base is
// haze, a rim, or a hole closed by the reconstruction, and a body on it would fall over although the object
// stood. Object frame, +Y up, metres. Pure functions.

namespace livegs {

struct StandingBase {
  double plane_m = 0.0;   // height of the base
  double lowest_m = 0.0;  // of the points below it that are moved onto it
  // Least horizontal distance of the centre of mass from the edge of the base over its height: the slope, as
  // a tangent, on which the thing begins to topple.
  double margin = 0.0;
  double widened = 1.0;                                // factor on the size of the base; 1: as captured
  Eigen::Vector2d middle_m = Eigen::Vector2d::Zero();  // x, z; mean of the corners of the base
};

// Slope on which a standing object must not topple, as a tangent; 3 degrees.
inline constexpr double kStandingMargin = 0.05;

// The lowest plane whose base, the convex hull of the points up to a small height above it, carries the
// centre of mass with kStandingMargin, and with a quarter of the largest margin of all planes. The plane is
// at most a tenth of the height above the lowest point; above that, the base of the best plane is widened
// about its centre. nullopt: no points, or without height.
std::optional<StandingBase> standing_base(std::span<const Eigen::Vector3d> points_m,
                                          const Eigen::Vector3d& centre_of_mass_m);

// Moves the points below the plane, and up to a small height above it, onto it, and widens the base about
// `centre_of_mass_m`. A closed mesh stays closed.
void flatten_base(std::span<Eigen::Vector3d> points_m, const StandingBase& base,
                  const Eigen::Vector3d& centre_of_mass_m);

}  // namespace livegs
