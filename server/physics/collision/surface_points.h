// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "geometry/field/sample_particles.h"

// Points of a deformable body at which it touches others.

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

// A part of the surface about a point, as a quadric: the points rest_m + u - u.S u n / 2 for tangential u up
// to reach_m, with S the curvature and n `bulge`. Where it touches depends on the direction of the other
// surface (touching_offset), so that round bodies roll.
struct SurfacePatch {
  Eigen::Vector3d rest_m;  // object frame
  std::vector<Eigen::Vector3d>
      normals;  // outward, unit, object frame; two or more at sharp edges and corners
  Eigen::Vector3d bulge = Eigen::Vector3d::Zero();  // unit: the normal, or that of the curve of a sharp edge
  // 1/m, symmetric, eigenvalues >= 0, zero along `bulge`; zero where the surface is flat or concave, and at
  // corners.
  Eigen::Matrix3d curvature = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d flatten = Eigen::Matrix3d::Zero();  // pseudoinverse of the curvature, m
  double reach_m = 0.0;                               // 0: without curvature
};
// Patches that cover the surface of the body's mesh, about one voxel apart, on the smooth surface that the
// mesh stands for. Without a mesh: the surface points of the particles, without curvature.
std::vector<SurfacePatch> surface_patches(const ParticleSet& particles);

// The offset, from the point of a patch, of its point that is deepest against `direction`, the outward unit
// normal of the other surface. Zero if the patch faces away. On a sphere of radius r the depth is exact to r
// a^4 / 8 at the angle a between the normals.
Eigen::Vector3d touching_offset(const SurfacePatch& patch, const Eigen::Vector3d& direction);

}  // namespace livegs
