// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/field/sample_particles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <tuple>
#include <utility>

#include "core/assert.h"
#include "core/disjoint_sets.h"
#include "core/math/pseudo_inverse.h"
#include "geometry/field/inside_grid.h"
#include "geometry/field/point_grid.h"
#include "geometry/mesh/mass_properties.h"
#include "geometry/mesh/mesh_topology.h"
#include "geometry/mesh/triangle_pieces.h"

namespace livegs {
namespace {

// Number of volume samples along an edge of a voxel. An odd number includes the voxel's centre.
constexpr int kSamplesPerVoxel = 3;
// Relative reduction of half a voxel diagonal. The corners of a box cut into whole voxels are exactly at that
// distance and must be taken despite rounding.
constexpr double kSlack = 1e-9;
// Maximum number of voxels; the spacing is enlarged above it. About ten times the number that runs in real
// time.
constexpr double kMaxVoxels = 1 << 20;
// Minimum volume of a particle, in voxels, before volumes are scaled to the body's. Prevents massless
// particles.
constexpr double kMinParticleVolume = 0.01;

// Distance below which two particles are connected: in voxels, or, if the particles stand for less than a
// voxel each, in edges of the cubes of their volume. Lattice cells are at least one and a half of those wide.
constexpr double kJointVoxels = 1.5, kJointCubes = 2.0;
// Initial spacing of points on triangles, in voxels, and its reduction factor per retry.
constexpr double kCoverVoxels = 0.75, kCoverRefinement = 0.7;
constexpr size_t kMaxCoverPoints = 20000;

RegularGrid cell_centres(const Eigen::AlignedBox3d& bounds, double cell_m) {
  RegularGrid grid;
  grid.cell_m = cell_m;
  grid.origin_m = bounds.min().array() + 0.5 * cell_m;
  grid.counts = ((bounds.sizes() / cell_m).array() - 1e-6).ceil().cast<int>().max(1);
  return grid;
}

template <class Visit>
void for_each_inside(const TriangleMesh& mesh, const RegularGrid& grid, const Visit& visit) {
  const std::vector<uint8_t> inside = nodes_inside(mesh, grid);
  for (int k = 0; k < grid.counts.z(); ++k) {
    for (int j = 0; j < grid.counts.y(); ++j) {
      for (int i = 0; i < grid.counts.x(); ++i) {
        if (inside[grid.index(i, j, k)]) visit(grid.point_m(i, j, k));
      }
    }
  }
}

// Assigns each volume sample to its nearest particle. Volume that the samples miss, in sheets thinner than
// their spacing, is distributed over the surface in the same way.
std::vector<double> share_volume(const TriangleMesh& mesh, const Eigen::AlignedBox3d& bounds,
                                 double spacing_m, double volume_m3, const PointGrid& particles) {
  std::vector<double> volumes_m3(particles.size(), 0.0);
  const double sample_m = affordable_cell_m(spacing_m / kSamplesPerVoxel, bounds.sizes());
  const double sample_m3 = sample_m * sample_m * sample_m;
  double sampled_m3 = 0.0;
  for_each_inside(mesh, cell_centres(bounds, sample_m), [&](const Eigen::Vector3d& point_m) {
    volumes_m3[particles.nearest(point_m)] += sample_m3;
    sampled_m3 += sample_m3;
  });
  const double missed_m3 = volume_m3 - sampled_m3;
  if (missed_m3 > 0.0) {
    double area_m2 = 0.0;
    std::vector<double> areas_m2(particles.size(), 0.0);
    for_each_triangle_piece(mesh, sample_m, [&](const Eigen::Vector3d& point_m, double piece_m2) {
      areas_m2[particles.nearest(point_m)] += piece_m2;
      area_m2 += piece_m2;
    });
    for (size_t i = 0; i < volumes_m3.size(); ++i) volumes_m3[i] += missed_m3 * areas_m2[i] / area_m2;
  }
  const double least_m3 =
      kMinParticleVolume * std::min(spacing_m * spacing_m * spacing_m, volume_m3 / particles.size());
  double sum_m3 = 0.0;
  for (double& share_m3 : volumes_m3) {
    share_m3 = std::max(share_m3, least_m3);
    sum_m3 += share_m3;
  }
  for (double& share_m3 : volumes_m3) share_m3 *= volume_m3 / sum_m3;
  return volumes_m3;
}

// Shifts the centre of the volumes to the centre of the mesh, because few points on a rod are unevenly
// distributed. Volumes are scaled by a factor that is linear in position, with the least total change. The
// factor changes by at most kMaxShift.
void centre_volumes(const TriangleMesh& mesh, ParticleSet& particles) {
  constexpr double kMaxShift = 0.7;
  const Eigen::Vector3d wanted_m = solid_mass_properties(mesh).centre_of_mass_m;
  double volume_m3 = 0.0;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < particles.positions_m.size(); ++i) {
    volume_m3 += particles.volumes_m3[i];
    centre_m += particles.volumes_m3[i] * particles.positions_m[i];
  }
  centre_m /= volume_m3;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (size_t i = 0; i < particles.positions_m.size(); ++i) {
    const Eigen::Vector3d arm = particles.positions_m[i] - centre_m;
    spread += particles.volumes_m3[i] / volume_m3 * arm * arm.transpose();
  }
  const Eigen::Vector3d slope = pseudo_inverse(spread) * (wanted_m - centre_m);
  double most = 0.0;
  for (const Eigen::Vector3d& point : particles.positions_m)
    most = std::max(most, std::abs(slope.dot(point - centre_m)));
  if (!std::isfinite(most)) return;
  const double part = most > kMaxShift ? kMaxShift / most : 1.0;
  for (size_t i = 0; i < particles.positions_m.size(); ++i) {
    particles.volumes_m3[i] *= 1.0 + part * slope.dot(particles.positions_m[i] - centre_m);
  }
}

// Returns the number of connected groups of particles if those closer than joint_m are connected.
int piece_count(const std::vector<Eigen::Vector3d>& points_m, double joint_m) {
  Eigen::AlignedBox3d bounds;
  for (const Eigen::Vector3d& point : points_m) bounds.extend(point);
  const auto cell_of = [&](const Eigen::Vector3d& point) -> Eigen::Vector3i {
    return ((point - bounds.min()) / joint_m).array().floor().cast<int>();
  };
  struct Place {
    std::array<int, 3> cell;  // z, y, x
    uint32_t point;
    bool operator<(const Place& other) const {
      return std::tie(cell, point) < std::tie(other.cell, other.point);
    }
  };
  std::vector<Place> places;
  for (uint32_t i = 0; i < points_m.size(); ++i) {
    const Eigen::Vector3i cell = cell_of(points_m[i]);
    places.push_back({{cell.z(), cell.y(), cell.x()}, i});
  }
  std::sort(places.begin(), places.end());
  DisjointSets sets(points_m.size());
  for (const Place& own : places) {
    for (int row = 0; row < 9; ++row) {  // cells of a row are consecutive
      const std::array<int, 3> first = {own.cell[0] + row / 3 - 1, own.cell[1] + row % 3 - 1,
                                        own.cell[2] - 1};
      auto other = std::lower_bound(places.begin(), places.end(), Place{first, 0});
      for (; other != places.end() && other->cell[0] == first[0] && other->cell[1] == first[1] &&
             other->cell[2] <= own.cell[2] + 1;
           ++other) {
        if ((points_m[own.point] - points_m[other->point]).norm() <= joint_m)
          sets.join(own.point, other->point);
      }
    }
  }
  int count = 0;
  for (uint32_t i = 0; i < points_m.size(); ++i) count += sets.find(i) == i;
  return count;
}

// Shuffles the points reproducibly. In the original order, the first face of a plate would take all the
// places and leave none to the other.
void shuffle(std::vector<Eigen::Vector3d>& points_m) {
  std::mt19937_64 engine(1);
  for (size_t left = points_m.size(); left > 1; --left)
    std::swap(points_m[left - 1], points_m[engine() % left]);
}

}  // namespace

ParticleSet sample_particles(const TriangleMesh& mesh, int density, double spacing_m) {
  LIVEGS_ASSERT(!mesh.triangles.empty() && density > 0);
  const Eigen::AlignedBox3d bounds = mesh_bounds_m(mesh);
  if (!(spacing_m > 0.0)) spacing_m = bounds.sizes().maxCoeff() / density;
  spacing_m = affordable_cell_m(spacing_m, bounds.sizes(), kMaxVoxels);

  ParticleSet particles;
  particles.spacing_m = spacing_m;
  const double volume_m3 = std::max(signed_volume_m3(mesh), 0.0);
  const double least_distance_m = 0.5 * std::sqrt(3.0) * spacing_m * (1.0 - kSlack);
  const PointGrid none({bounds.min(), bounds.max().array() + spacing_m}, spacing_m);
  PointGrid taken = none;
  const auto take = [&](const Eigen::Vector3d& point_m, bool on_surface) {
    taken.insert(point_m);
    particles.positions_m.push_back(point_m);
    particles.on_surface.push_back(on_surface);
  };
  for_each_inside(mesh, cell_centres(bounds, spacing_m), [&](const Eigen::Vector3d& p) { take(p, false); });
  const size_t voxels = particles.positions_m.size();
  std::vector<bool> used(mesh.vertices_m.size(), false);
  for (const auto& triangle : mesh.triangles) {
    for (uint32_t vertex : triangle) used[vertex] = true;
  }
  std::vector<uint32_t> among_used(mesh.vertices_m.size(), 0);
  for (size_t v = 0; v < mesh.vertices_m.size(); ++v) {
    among_used[v] = static_cast<uint32_t>(particles.mesh_vertices_m.size());
    if (used[v]) particles.mesh_vertices_m.push_back(mesh.vertices_m[v]);
    if (used[v] && !taken.has_neighbour_within(mesh.vertices_m[v], least_distance_m))
      take(mesh.vertices_m[v], true);
  }

  for (const auto& triangle : mesh.triangles) {
    particles.mesh_triangles.push_back(
        {among_used[triangle[0]], among_used[triangle[1]], among_used[triangle[2]]});
  }

  const std::vector<int> pieces = mesh_pieces(mesh);
  particles.piece_count = 1 + *std::max_element(pieces.begin(), pieces.end());
  const bool thin = static_cast<double>(voxels) * std::pow(spacing_m, 3) < 0.5 * volume_m3;
  const auto hang_together = [&] {
    const double cube_m = std::cbrt(volume_m3 / static_cast<double>(particles.positions_m.size()));
    const double joint_m =
        thin ? std::min(kJointVoxels * spacing_m, kJointCubes * cube_m) : kJointVoxels * spacing_m;
    return joint_m <= 0.0 || piece_count(particles.positions_m, joint_m) <= particles.piece_count;
  };
  const ParticleSet bare = particles;
  for (double apart_m = kCoverVoxels * spacing_m;
       !hang_together() && particles.positions_m.size() < kMaxCoverPoints; apart_m *= kCoverRefinement) {
    particles = bare;
    particles.surface_carries = true;
    taken = none;
    for (const Eigen::Vector3d& point : bare.positions_m) taken.insert(point);
    std::vector<Eigen::Vector3d> places;
    for_each_triangle_piece(mesh, 0.5 * apart_m,
                            [&](const Eigen::Vector3d& point_m, double) { places.push_back(point_m); });
    shuffle(places);
    for (const Eigen::Vector3d& point_m : places) {
      if (particles.positions_m.size() < kMaxCoverPoints && !taken.has_neighbour_within(point_m, apart_m))
        take(point_m, true);
    }
  }
  particles.volumes_m3 = share_volume(mesh, bounds, spacing_m, volume_m3, taken);
  if (particles.surface_carries) centre_volumes(mesh, particles);
  return particles;
}

}  // namespace livegs
