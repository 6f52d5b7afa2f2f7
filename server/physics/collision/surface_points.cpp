// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/collision/surface_points.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "geometry/mesh/smooth_surface.h"
#include "physics/collision/contact_candidate.h"

namespace livegs {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Key = std::array<int64_t, 3>;

struct KeyHash {
  size_t operator()(const Key& key) const {
    uint64_t hash = 0x9e3779b97f4a7c15u;
    for (const int64_t part : key) hash = (hash ^ static_cast<uint64_t>(part)) * 0xff51afd7ed558ccdu;
    return hash ^ hash >> 32;
  }
};

// Cell of a point in a grid with cells of `edge_m`.
Key key_of(const Vector3d& p, double edge_m) {
  const auto cell = [&](double x) { return static_cast<int64_t>(std::floor(x / edge_m)); };
  return {cell(p.x()), cell(p.y()), cell(p.z())};
}

// Distance between patches on the same side of the surface, in voxels. The points of a box cut into whole
// voxels are at least one apart.
constexpr double kPatchSpacing = 0.7;
// Reach of a patch, in its radii of curvature, up to which the quadric is near a circle: within 1 % of the
// radius.
constexpr double kMaxReachInRadii = 0.5;

// Hash grid of particles for neighbourhood queries.
class VoxelMap {
 public:
  VoxelMap(const ParticleSet& particles, double edge) : particles_(particles), edge_(edge) {
    for (size_t i = 0; i < particles.positions_m.size(); ++i)
      voxels_[key_of(particles.positions_m[i], edge)].push_back(i);
  }

  // Whether `accept` returns true for any particle within a cube.
  template <class Accept>
  bool any_within(const Vector3d& centre, double half, const Accept& accept) const {
    const Key low = key_of(centre - Vector3d::Constant(half), edge_);
    const Key high = key_of(centre + Vector3d::Constant(half), edge_);
    for (int64_t x = low[0]; x <= high[0]; ++x) {
      for (int64_t y = low[1]; y <= high[1]; ++y) {
        for (int64_t z = low[2]; z <= high[2]; ++z) {
          const auto found = voxels_.find({x, y, z});
          if (found == voxels_.end()) continue;
          for (const size_t i : found->second) {
            if ((particles_.positions_m[i] - centre).cwiseAbs().maxCoeff() <= half && accept(i)) return true;
          }
        }
      }
    }
    return false;
  }

 private:
  const ParticleSet& particles_;
  double edge_;
  // Never iterated, so the hash order has no effect.
  std::unordered_map<Key, std::vector<size_t>, KeyHash> voxels_;
};

// Patches taken so far, to keep them apart.
class TakenPatches {
 public:
  explicit TakenPatches(double apart_m) : apart_m_(apart_m) {}

  bool has_neighbour(const Vector3d& point_m, const Vector3d& normal) const {
    const Key at = key_of(point_m, apart_m_);
    for (int k = 0; k < 27; ++k) {
      const auto found = cells_.find({at[0] + k % 3 - 1, at[1] + k / 3 % 3 - 1, at[2] + k / 9 - 1});
      if (found == cells_.end()) continue;
      for (const auto& [other_m, others_normal] : found->second) {
        if ((other_m - point_m).norm() < apart_m_ && others_normal.dot(normal) > kSameSideCosine) return true;
      }
    }
    return false;
  }
  void insert(const Vector3d& point_m, const Vector3d& normal) {
    cells_[key_of(point_m, apart_m_)].push_back({point_m, normal});
  }

 private:
  double apart_m_;
  std::unordered_map<Key, std::vector<std::pair<Vector3d, Vector3d>>, KeyHash> cells_;  // never iterated
};

// A patch with the curvatures above the least that counts.
SurfacePatch patch_of(const SmoothSurface::Foot& foot, double reach_m) {
  SurfacePatch patch{foot.point_m, foot.normals, foot.bulge};
  if (reach_m <= 0.0) return patch;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> principal(foot.curvature);
  // A patch with a radius of more than 100 reaches is flat: it bulges by less than half a per cent of its
  // reach.
  const double least = 1.0 / (100.0 * reach_m);
  for (int k = 0; k < 3; ++k) {
    const double bend = principal.eigenvalues()[k];
    if (!(bend > least)) continue;
    const Matrix3d along = principal.eigenvectors().col(k) * principal.eigenvectors().col(k).transpose();
    patch.curvature += bend * along;
    patch.flatten += along / bend;
    patch.reach_m = std::min(reach_m, kMaxReachInRadii / bend);
  }
  return patch;
}

Vector3d mean_normal(const std::vector<Vector3d>& normals) {
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& normal : normals) sum += normal;
  return sum.norm() > 0.0 ? Vector3d(sum.normalized()) : normals.front();
}

}  // namespace

std::vector<SurfacePoint> surface_points(const ParticleSet& particles) {
  const size_t count = particles.positions_m.size();
  double volume = 0.0;
  for (const double v : particles.volumes_m3) volume += v;
  const double edge =
      particles.spacing_m > 0.0 ? particles.spacing_m : std::cbrt(volume / static_cast<double>(count));
  const VoxelMap map(particles, edge);
  const auto on_surface = [&](size_t i) {
    return i < particles.on_surface.size() && particles.on_surface[i];
  };

  Vector3d middle = Vector3d::Zero();
  for (size_t i = 0; i < count; ++i) middle += particles.volumes_m3[i] / volume * particles.positions_m[i];
  // Direction away from the centroid of the material within two voxels.
  const auto away_from_material = [&](const Vector3d& p) -> Vector3d {
    Vector3d away = Vector3d::Zero();
    map.any_within(p, 2.0 * edge, [&](size_t j) {
      const Vector3d from = p - particles.positions_m[j];
      if (from.norm() < 2.0 * edge) away += particles.volumes_m3[j] * from;
      return false;
    });
    if (!(away.norm() > 1e-9 * volume * edge)) away = p - middle;
    return away.norm() > 0.0 ? Vector3d(away.normalized()) : Vector3d::UnitY();
  };

  // Snaps points on the outermost voxel faces to the mesh bounds, if there is a mesh.
  Eigen::AlignedBox3d mesh, voxels;
  for (const Vector3d& vertex : particles.mesh_vertices_m) mesh.extend(vertex);
  for (size_t i = 0; i < count; ++i) {
    if (on_surface(i)) continue;
    voxels.extend(Vector3d(particles.positions_m[i].array() - 0.5 * edge));
    voxels.extend(Vector3d(particles.positions_m[i].array() + 0.5 * edge));
  }
  const auto on_face = [&](Vector3d point) {
    for (int d = 0; d < 3 && !mesh.isEmpty(); ++d) {
      if (std::abs(mesh.min()[d] - voxels.min()[d]) <= edge && point[d] < voxels.min()[d] + 1e-6 * edge) {
        point[d] = mesh.min()[d];
      }
      if (std::abs(mesh.max()[d] - voxels.max()[d]) <= edge && point[d] > voxels.max()[d] - 1e-6 * edge) {
        point[d] = mesh.max()[d];
      }
      point[d] = std::clamp(point[d], mesh.min()[d], mesh.max()[d]);
    }
    return point;
  };

  std::vector<SurfacePoint> points;
  for (size_t i = 0; i < count; ++i) {
    const Vector3d& p = particles.positions_m[i];
    if (on_surface(i)) {
      points.push_back({static_cast<uint32_t>(i), p, 0.0, {away_from_material(p)}});
      continue;
    }
    std::array<std::array<bool, 2>, 3> open{};  // whether each side is empty
    bool inner = true;
    for (int d = 0; d < 3; ++d) {
      for (const int side : {0, 1}) {
        const double sign = side ? 1.0 : -1.0;
        open[d][side] = !map.any_within(p + sign * edge * Vector3d::Unit(d), 0.6 * edge, [&](size_t j) {
          return j != i && sign * (particles.positions_m[j] - p)[d] > 0.0;
        });
        inner = inner && !open[d][side];
      }
    }
    if (inner || map.any_within(p, edge, on_surface)) continue;
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        for (int z = -1; z <= 1; ++z) {
          const std::array<int, 3> side{x, y, z};
          bool outermost = true;
          for (int d = 0; d < 3; ++d) {
            outermost = outermost && (side[d] ? open[d][side[d] > 0] : !open[d][0] && !open[d][1]);
          }
          if (!outermost) continue;
          SurfacePoint& point = points.emplace_back(SurfacePoint{
              static_cast<uint32_t>(i), on_face(p + 0.5 * edge * Vector3d(x, y, z)), 0.5 * edge, {}});
          for (int d = 0; d < 3; ++d) {
            if (side[d]) point.normals.push_back(side[d] * Vector3d::Unit(d));
          }
        }
      }
    }
  }
  return points;
}

std::vector<SurfacePatch> surface_patches(const ParticleSet& particles) {
  std::vector<SurfacePatch> patches;
  const std::vector<SurfacePoint> points = surface_points(particles);
  if (particles.mesh_triangles.empty()) {
    for (const SurfacePoint& point : points) patches.push_back({point.rest_m, point.normals});
    return patches;
  }
  const double edge_m = particles.spacing_m;
  const SmoothSurface surface({particles.mesh_vertices_m, particles.mesh_triangles});
  TakenPatches taken(kPatchSpacing * edge_m);
  // A voxel is more than half the widest gap between patches. Parts thinner than that, such as leaves, end
  // within the reach of a patch.
  const double reach_m = particles.surface_carries ? 0.0 : edge_m;
  const auto take = [&](const SmoothSurface::Foot& foot, bool apart) {
    const Vector3d normal = mean_normal(foot.normals);
    if (apart && taken.has_neighbour(foot.point_m, normal)) return;
    taken.insert(foot.point_m, normal);
    patches.push_back(patch_of(foot, reach_m));
  };
  // Corners first, then sharp edges, so that no point next to them takes their place. Points that carry the
  // material of parts thinner than a voxel all count.
  const auto [corners_m, edges_m] = surface.sharp_points(edge_m);
  for (const Vector3d& point_m : corners_m) take(surface.nearest(point_m), true);
  std::vector<SmoothSurface::Foot> smooth;
  for (const SurfacePoint& point : points) {
    SmoothSurface::Foot foot = surface.nearest(point.rest_m);
    if (foot.normals.size() > 1)
      take(foot, true);
    else
      smooth.push_back(std::move(foot));
  }
  for (const Vector3d& point_m : edges_m) take(surface.nearest(point_m), true);
  for (const SmoothSurface::Foot& foot : smooth) take(foot, !particles.surface_carries);
  return patches;
}

Vector3d touching_offset(const SurfacePatch& patch, const Vector3d& direction) {
  const double facing = -direction.dot(patch.bulge);
  if (!(facing > 0.01)) return Vector3d::Zero();           // the patch faces away
  Vector3d along = -(patch.flatten * direction) / facing;  // flatten is zero along the bulge
  const double length = along.norm();
  if (length > patch.reach_m) along *= patch.reach_m / length;
  return along - 0.5 * along.dot(patch.curvature * along) * patch.bulge;
}

}  // namespace livegs
