// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/collision/point_contact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include "physics/collision/conservative_advancement.h"

namespace livegs {
namespace {

using Eigen::Vector3d;
using Key = std::array<int64_t, 3>;

struct KeyHash {
  size_t operator()(const Key& key) const {
    uint64_t hash = 0x9e3779b97f4a7c15u;
    for (const int64_t part : key) hash = (hash ^ static_cast<uint64_t>(part)) * 0xff51afd7ed558ccdu;
    return hash ^ hash >> 32;
  }
};

// Maximum number of marching steps out of a solid; thin walls need few.
constexpr int kMaxMarches = 32;

// Thickness that a point can tunnel through, m.
double thickness_m(const Collider& collider) {
  if (const auto* box = std::get_if<BoxShape>(&collider.shape)) return box->size_m.minCoeff();
  if (const auto* sphere = std::get_if<SphereShape>(&collider.shape)) return 2.0 * sphere->radius_m;
  if (const auto* field = std::get_if<FieldShape>(&collider.shape)) return min_thickness_m(*field);
  return INFINITY;
}

// Hash grid of particles for neighbourhood queries.
class VoxelMap {
 public:
  VoxelMap(const ParticleSet& particles, double edge) : particles_(particles), edge_(edge) {
    for (size_t i = 0; i < particles.positions_m.size(); ++i)
      voxels_[key(particles.positions_m[i])].push_back(i);
  }

  // Whether `accept` returns true for any particle within a cube.
  template <class Accept>
  bool any_within(const Vector3d& centre, double half, const Accept& accept) const {
    const Key low = key(centre - Vector3d::Constant(half)), high = key(centre + Vector3d::Constant(half));
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
  Key key(const Vector3d& p) const {
    const auto cell = [&](double x) { return static_cast<int64_t>(std::floor(x / edge_)); };
    return {cell(p.x()), cell(p.y()), cell(p.z())};
  }
  const ParticleSet& particles_;
  double edge_;
  // Never iterated, so the hash order has no effect.
  std::unordered_map<Key, std::vector<size_t>, KeyHash> voxels_;
};

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

Vector3d contact_correction(const Vector3d& normal, double depth_m, const Vector3d& moved_m,
                            double friction) {
  const Vector3d slid = moved_m - normal * normal.dot(moved_m);
  const double displacement = slid.norm(), hold = friction * depth_m;
  const double part = displacement > hold ? hold / displacement : 1.0;
  return depth_m * normal - part * slid;
}

SurfaceSample swept_surface(const ColliderProbe& collider, const Vector3d& from_m, const Vector3d& to_m,
                            const Vector3d& side) {
  const SurfaceSample at = collider.sample(to_m);
  const double thickness = thickness_m(collider.collider());
  if (!(thickness < INFINITY)) return at;
  const Vector3d displacement = to_m - from_m;
  const bool sided = side.squaredNorm() > 0.0,
             fast = displacement.squaredNorm() > kMaxUnsweptPart * kMaxUnsweptPart * thickness * thickness;
  if (!fast && (!sided || at.distance_m > 0.0 || at.normal.dot(side) > 0.0)) return at;
  const double start_m = collider.sample(from_m).distance_m;
  const double tolerance = 0.01 * thickness;
  if (sided && start_m < 0.0) {
    if (at.distance_m < 0.0 && at.normal.dot(side) > 0.0) return at;
    double out = 0.0;
    for (int march = 0; march < kMaxMarches; ++march) {
      const double inside = -collider.sample(from_m + out * side).distance_m;
      if (inside <= 0.0) break;
      out += std::max(inside, tolerance);
    }
    return {side.dot(displacement) - out, side};
  }
  if (!fast) return at;
  const auto sample = [&](const Vector3d& point) { return collider.sample(point); };
  const auto hit = cast_sphere(sample, from_m, displacement, 0.0, tolerance);
  if (!hit) return at;
  return {hit->separation_m + hit->normal.dot(displacement), hit->normal};
}

bool reaches(const Collider& collider, const Vector3d& centre_m, double radius_m) {
  const auto* field = std::get_if<FieldShape>(&collider.shape);
  const double margin = field ? 2.0 * field->field->cell_m() : 0.0;
  return sample_surface(collider, centre_m).distance_m <= radius_m + margin;
}

void reachable_colliders(std::span<const Collider> colliders, const Vector3d& centre_m, double reach_m,
                         std::vector<const Collider*>& reachable) {
  reachable.clear();
  for (const Collider& collider : colliders) {
    if (reaches(collider, centre_m, reach_m)) reachable.push_back(&collider);
  }
}

}  // namespace livegs
