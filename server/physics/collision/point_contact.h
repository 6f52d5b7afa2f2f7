// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "geometry/field/sample_particles.h"
#include "physics/collider.h"

// Contact of one sampled point of a deformable body: a correction of its position at the end of a substep.

namespace livegs {

// A material point of the body's surface and its particle.
struct SurfacePoint {
  uint32_t particle;
  Eigen::Vector3d rest_m;  // object frame
  double radius_m;         // of the particle if it is treated as a ball
  // Outward unit normals, object frame, one for each face at the point; two or three at voxel edges and
  // corners.
  std::vector<Eigen::Vector3d> normals;
};
// Contact points of the particles. Particles at mesh vertices are used as they are. Boundary voxels without a
// nearby vertex contribute the centre of their outer face, edge or corner, two to eight points if opposite
// sides are open. This covers coarse meshes and point clouds.
std::vector<SurfacePoint> surface_points(const ParticleSet& particles);

// Moves the point out of the solid along the normal. Friction moves it back towards its position at the start
// of the substep, by at most `friction` times the depth (Coulomb's law on positions). `moved_m` is the
// displacement relative to the solid since then.
Eigen::Vector3d contact_correction(const Eigen::Vector3d& normal, double depth_m,
                                   const Eigen::Vector3d& moved_m, double friction);

// Gap and normal that resolve the contact of a point moving from `from_m` to `to_m`. Thin colliders are
// resolved on the side the point moved from: a fast point is swept along its displacement, and a point that
// starts inside leaves along `side`, its previous contact normal (zero: none).
SurfaceSample swept_surface(const ColliderProbe& collider, const Eigen::Vector3d& from_m,
                            const Eigen::Vector3d& to_m, const Eigen::Vector3d& side);

// Whether a ball may touch the collider. Conservative by two cells of a distance field.
bool reaches(const Collider& collider, const Eigen::Vector3d& centre_m, double radius_m);
void reachable_colliders(std::span<const Collider> colliders, const Eigen::Vector3d& centre_m, double reach_m,
                         std::vector<const Collider*>& reachable);

}  // namespace livegs
