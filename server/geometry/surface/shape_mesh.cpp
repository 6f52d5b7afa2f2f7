// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/surface/shape_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "core/assert.h"

namespace livegs {
namespace {

// A surface of revolution about +Y: rings of (radius, height) from the top down, closed by a pole at each
// end.
TriangleMesh revolve(double top_m, const std::vector<std::pair<double, double>>& rings_m, double bottom_m,
                     int segments) {
  LIVEGS_ASSERT(segments >= 3 && !rings_m.empty());
  TriangleMesh mesh;
  const auto around = static_cast<uint32_t>(segments);
  mesh.vertices_m.emplace_back(0.0, top_m, 0.0);
  for (const auto& [radius_m, height_m] : rings_m) {
    for (uint32_t s = 0; s < around; ++s) {
      const double angle = 2.0 * std::numbers::pi * s / segments;
      mesh.vertices_m.emplace_back(radius_m * std::sin(angle), height_m, radius_m * std::cos(angle));
    }
  }
  mesh.vertices_m.emplace_back(0.0, bottom_m, 0.0);
  const uint32_t last = static_cast<uint32_t>(mesh.vertices_m.size()) - 1;
  const auto ring_count = static_cast<uint32_t>(rings_m.size());
  for (uint32_t s = 0; s < around; ++s) {
    const uint32_t next = (s + 1) % around;
    mesh.triangles.push_back({0, 1 + s, 1 + next});
    for (uint32_t r = 0; r + 1 < ring_count; ++r) {
      const uint32_t upper = 1 + r * around, lower = upper + around;
      mesh.triangles.push_back({upper + s, lower + s, lower + next});
      mesh.triangles.push_back({upper + s, lower + next, upper + next});
    }
    const uint32_t lowest = 1 + (ring_count - 1) * around;
    mesh.triangles.push_back({last, lowest + next, lowest + s});
  }
  return mesh;
}

}  // namespace

TriangleMesh box_mesh(const Eigen::Vector3d& size_m) {
  LIVEGS_ASSERT(size_m.minCoeff() > 0.0);
  TriangleMesh mesh;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d side(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 0.5 : -0.5);
    mesh.vertices_m.push_back(size_m.cwiseProduct(side));
  }
  mesh.triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  return mesh;
}

TriangleMesh sphere_mesh(double radius_m, int subdivisions) {
  LIVEGS_ASSERT(radius_m > 0.0 && subdivisions >= 0 && subdivisions <= 7);
  TriangleMesh mesh;
  const double g = std::numbers::phi;
  for (double a : {-1.0, 1.0}) {
    for (double b : {-g, g}) {
      mesh.vertices_m.emplace_back(0.0, a, b);
      mesh.vertices_m.emplace_back(a, b, 0.0);
      mesh.vertices_m.emplace_back(b, 0.0, a);
    }
  }
  for (auto& vertex : mesh.vertices_m) vertex.normalize();
  // Faces of the icosahedron: all vertex triples at the edge length, outward-facing.
  const double edge = 2.0 / std::sqrt(1.0 + g * g);
  const auto adjacent = [&](uint32_t a, uint32_t b) {
    return std::abs((mesh.vertices_m[a] - mesh.vertices_m[b]).norm() - edge) < 1e-6;
  };
  for (uint32_t a = 0; a < 12; ++a) {
    for (uint32_t b = a + 1; b < 12; ++b) {
      for (uint32_t c = b + 1; c < 12; ++c) {
        if (!adjacent(a, b) || !adjacent(b, c) || !adjacent(a, c)) continue;
        const bool outwards = mesh.vertices_m[a].dot(mesh.vertices_m[b].cross(mesh.vertices_m[c])) > 0.0;
        mesh.triangles.push_back(outwards ? std::array{a, b, c} : std::array{a, c, b});
      }
    }
  }
  for (int level = 0; level < subdivisions; ++level) {
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
    const auto middle = [&](uint32_t a, uint32_t b) {
      const auto [entry, fresh] =
          middles.try_emplace(std::minmax(a, b), static_cast<uint32_t>(mesh.vertices_m.size()));
      if (fresh) mesh.vertices_m.push_back((mesh.vertices_m[a] + mesh.vertices_m[b]).normalized());
      return entry->second;
    };
    std::vector<std::array<uint32_t, 3>> finer;
    finer.reserve(mesh.triangles.size() * 4);
    for (const auto& [a, b, c] : mesh.triangles) {
      const uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(finer);
  }
  for (auto& vertex : mesh.vertices_m) vertex *= radius_m;
  return mesh;
}

TriangleMesh cylinder_mesh(double radius_m, double height_m, int segments) {
  LIVEGS_ASSERT(radius_m > 0.0 && height_m > 0.0);
  const double half_m = 0.5 * height_m;
  return revolve(half_m, {{radius_m, half_m}, {radius_m, -half_m}}, -half_m, segments);
}

TriangleMesh capsule_mesh(double radius_m, double height_m, int segments) {
  LIVEGS_ASSERT(radius_m > 0.0 && height_m > 0.0);
  const double half_m = 0.5 * height_m;
  const int rings = std::max(segments / 4, 2);  // from the pole to the equator of a cap
  std::vector<std::pair<double, double>> profile_m;
  for (int r = 1; r <= rings; ++r) {
    const double polar = 0.5 * std::numbers::pi * r / rings;
    profile_m.emplace_back(r == rings ? radius_m : radius_m * std::sin(polar),
                           half_m + (r == rings ? 0.0 : radius_m * std::cos(polar)));
  }
  for (int r = rings; r >= 1; --r) profile_m.emplace_back(profile_m[r - 1].first, -profile_m[r - 1].second);
  return revolve(half_m + radius_m, profile_m, -half_m - radius_m, segments);
}

}  // namespace livegs
