// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>

#include "geometry/surface/shape_mesh.h"
#include "geometry/triangle_mesh.h"

namespace livegs::testing {

// A surface of revolution about +Y through the (radius, height) points. The first and last point lie on the
// axis.
inline TriangleMesh turned(const std::vector<Eigen::Vector2d>& profile, int segments) {
  TriangleMesh mesh;
  const auto last = static_cast<uint32_t>(profile.size() - 1);
  mesh.vertices_m.emplace_back(0, profile[0].y(), 0);
  for (uint32_t p = 1; p < last; ++p) {
    for (int s = 0; s < segments; ++s) {
      const double turn = 2 * std::numbers::pi * s / segments;
      mesh.vertices_m.emplace_back(profile[p].x() * std::cos(turn), profile[p].y(),
                                   -profile[p].x() * std::sin(turn));
    }
  }
  mesh.vertices_m.emplace_back(0, profile[last].y(), 0);
  const auto top = static_cast<uint32_t>(mesh.vertices_m.size() - 1);
  const auto at = [&](uint32_t p, int s) {
    return p == 0 ? 0u : p == last ? top : 1 + (p - 1) * segments + static_cast<uint32_t>(s % segments);
  };
  for (uint32_t p = 0; p < last; ++p) {
    for (int s = 0; s < segments; ++s) {
      const uint32_t a = at(p, s), b = at(p, s + 1), c = at(p + 1, s + 1), d = at(p + 1, s);
      if (p > 0) mesh.triangles.push_back({a, b, c});
      if (p + 1 < last) mesh.triangles.push_back({a, c, d});
    }
  }
  return mesh;
}

// A cylinder of 80 x 100 mm with a bore of 72 mm from the top to 5 mm above the bottom: walls of 4 mm.
inline TriangleMesh cup_mesh(int segments = 64, int rows = 20) {
  std::vector<Eigen::Vector2d> profile{{0, 0}};
  for (int r = 0; r <= rows; ++r) profile.emplace_back(0.04, 0.1 * r / rows);
  for (int r = rows; r >= 0; --r) profile.emplace_back(0.036, 0.005 + 0.095 * r / rows);
  profile.emplace_back(0, 0.005);
  return turned(profile, segments);
}

// A ball of radius 50 mm with a closed cavity of radius 40 mm.
inline TriangleMesh hollow_ball() {
  TriangleMesh mesh = sphere_mesh(0.05, 3);
  const TriangleMesh inner = sphere_mesh(0.04, 3);
  const auto start = static_cast<uint32_t>(mesh.vertices_m.size());
  mesh.vertices_m.insert(mesh.vertices_m.end(), inner.vertices_m.begin(), inner.vertices_m.end());
  for (const auto& [a, b, c] : inner.triangles) mesh.triangles.push_back({start + a, start + c, start + b});
  return mesh;
}

}  // namespace livegs::testing
