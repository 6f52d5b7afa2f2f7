// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "geometry/field/sample_particles.h"
#include "physics/collider.h"

// Contact of one sampled point of a deformable body, as a correction of its position at the end of a substep.

namespace livegs {

// A material point of the body's surface and the particle it belongs to.
struct SurfacePoint {
  uint32_t particle;
  Eigen::Vector3d rest_m;  // object frame
  double radius_m;         // from the particle, when it is taken for a ball around its centre
  // Outwards, unit, object frame: of each face that meets there, at an edge or a corner of voxels two or
  // three.
  std::vector<Eigen::Vector3d> normals;
};
// Mesh vertices stand on the surface. Voxels count where they are at the edge of the body and no vertex is
// near, since a coarse mesh has few vertices and a cloud of points none: by the middle of their outer face,
// edge or corner, two to eight of them where both sides are open.
std::vector<SurfacePoint> surface_points(const ParticleSet& particles);

// Takes the point out of the solid along the normal; friction holds it to where it was at the start of the
// substep, by at most `friction` times the depth (Coulomb's law on positions). `moved_m` is the way it went
// relative to the solid since then.
Eigen::Vector3d contact_correction(const Eigen::Vector3d& normal, double depth_m,
                                   const Eigen::Vector3d& moved_m, double friction);

// Of a collider where a point ends that goes from `from_m` to `to_m`: the gap and the normal to take it out
// by. A thin collider is met on the side that the point comes from: a fast one is followed along its way, and
// one that starts inside goes out on `side`, the normal it was met by before (zero: none).
SurfaceSample swept_surface(const ColliderProbe& collider, const Eigen::Vector3d& from_m,
                            const Eigen::Vector3d& to_m, const Eigen::Vector3d& side);

// Whether a ball may touch the collider; distance fields are trusted to two cells.
bool reaches(const Collider& collider, const Eigen::Vector3d& centre_m, double radius_m);
void reachable_colliders(std::span<const Collider> colliders, const Eigen::Vector3d& centre_m, double reach_m,
                         std::vector<const Collider*>& reachable);

}  // namespace livegs
