// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "geometry/triangle_mesh.h"

namespace livegs {

// LIVE-GS's sampling density: voxels along the longest side of the bounding box.
inline constexpr int kDefaultSamplingDensity = 15;

// The particles of an elastic body at rest, in the object frame.
struct ParticleSet {
  double spacing_m = 0.0;  // edge of a voxel
  std::vector<Eigen::Vector3d> positions_m;
  std::vector<double> volumes_m3;  // sums to the volume of the body
  std::vector<bool> on_surface;    // vertices and points of a mesh; the rest are voxel centres
  std::vector<Eigen::Vector3d>
      mesh_vertices_m;  // all, of the mesh they were sampled from; empty for a list of points
  std::vector<std::array<uint32_t, 3>> mesh_triangles;  // of those
  bool surface_carries =
      false;            // there are points on triangles, which stand for what is thinner than a voxel
  int piece_count = 0;  // of the mesh; 0: a list of points
};

// LIVE-GS's rule: one particle at the centre of each voxel inside the mesh, and mesh vertices at least half a
// voxel diagonal from every particle taken before. spacing_m > 0 overrides the density rule; one that would
// make more than a million voxels is widened. Where these are too far apart to hang together as the mesh does
// (a rod or a plate thinner than a voxel has its corners only), points on its triangles too, up to 20000
// particles in all. The mesh's volume is shared among the particles by what lies nearest. Precondition: a
// closed mesh. Never returns fewer than one particle.
ParticleSet sample_particles(const TriangleMesh& mesh, int density = kDefaultSamplingDensity,
                             double spacing_m = 0.0);

}  // namespace livegs
