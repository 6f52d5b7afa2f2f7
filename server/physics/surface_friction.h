// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <vector>

// Friction over the surface of a rigid body, which may consist of parts of several materials.

namespace livegs {

inline constexpr double kMaxFriction = 2.0;
// From ice to rubber is a factor of about 50.
inline constexpr double kMaxFrictionFactor = 1e3;

struct FrictionBox {
  Eigen::AlignedBox3d box;  // object frame at rest, metres; a side may be infinite
  double factor = 1.0;      // friction in the box over that of the object's material; 0 or above
};

struct SurfaceFriction {
  double own = 0.5;                                       // of the object's material, 0 … kMaxFriction
  std::shared_ptr<const std::vector<FrictionBox>> boxes;  // null: `own` everywhere

  // At a point of the surface, object frame at rest; the last box that contains the point applies.
  // `body_radius_m` is the bounding radius: contact points may lie a hundredth of it outside the surface.
  double at(const Eigen::Vector3d& rest_point_m, double body_radius_m) const;
};

}  // namespace livegs
