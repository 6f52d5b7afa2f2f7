// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "physics/collider.h"

// Contact of one sampled point of a deformable body: a correction of its position at the end of a substep.

namespace livegs {

// Moves the point out of the solid along the normal. Friction moves it back towards its position at the start
// of the substep, by at most `friction` times the depth (Coulomb's law on positions). `moved_m` is the
// displacement relative to the solid since then.
Eigen::Vector3d contact_correction(const Eigen::Vector3d& normal, double depth_m,
                                   const Eigen::Vector3d& moved_m, double friction);

// Gap and normal that resolve the contact of a point moving from `from_m` to `to_m`. Thin colliders are
// resolved on the side a fast point moved from: it is swept along its displacement.
SurfaceSample swept_surface(const ColliderProbe& collider, const Eigen::Vector3d& from_m,
                            const Eigen::Vector3d& to_m);

// Whether a ball may touch the collider. Conservative by two cells of a distance field.
bool reaches(const Collider& collider, const Eigen::Vector3d& centre_m, double radius_m);
void reachable_colliders(std::span<const Collider> colliders, const Eigen::Vector3d& centre_m, double reach_m,
                         std::vector<const Collider*>& reachable);

}  // namespace livegs
