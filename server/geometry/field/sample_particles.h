// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "geometry/triangle_mesh.h"

namespace livegs {

// Sampling density of LIVE-GS: voxels along the longest side of the bounding box.
inline constexpr int kDefaultSamplingDensity = 15;

// Particles of an elastic body at rest, object frame.
struct ParticleSet {
  double spacing_m = 0.0;  // edge of a voxel
  std::vector<Eigen::Vector3d> positions_m;
  std::vector<double> volumes_m3;  // the sum is the volume of the body
  std::vector<bool> on_surface;    // mesh vertices and surface points; the others are voxel centres
  std::vector<Eigen::Vector3d> mesh_vertices_m;         // of the sampled mesh; empty for a list of points
  std::vector<std::array<uint32_t, 3>> mesh_triangles;  // indices into mesh_vertices_m
  bool surface_carries = false;  // has points on triangles, for parts thinner than a voxel
  int piece_count = 0;           // connected parts of the mesh; 0 for a list of points
};

// Samples particles by the rule of LIVE-GS: one at the centre of each voxel inside the mesh, and mesh
// vertices at least half a voxel diagonal from all earlier particles.
// - spacing_m > 0 overrides the density; it is enlarged if it would give more than a million voxels.
// - If these particles are too sparse to connect as the mesh does, as in a thin rod or plate, points on the
//   triangles are added, up to 20000 particles in all.
// - The mesh's volume is distributed to the nearest particles.
// Precondition: a closed mesh. Returns at least one particle.
ParticleSet sample_particles(const TriangleMesh& mesh, int density = kDefaultSamplingDensity,
                             double spacing_m = 0.0);

}  // namespace livegs
