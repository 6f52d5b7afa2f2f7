// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/environment/interior_collider.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/log.h"
#include "geometry/reconstruct_surface.h"
#include "prepare/mesh_collider.h"

namespace livegs {
namespace {

using Eigen::Vector3d;

constexpr size_t kMaxCuts = 4;
constexpr int kMaxMarches = 256;
constexpr double kHeightStep = 0.5;  // step between candidate heights, in ball radii

void append(TriangleMesh& all, const TriangleMesh& part) {
  const auto start = static_cast<uint32_t>(all.vertices_m.size());
  all.vertices_m.insert(all.vertices_m.end(), part.vertices_m.begin(), part.vertices_m.end());
  for (const auto& [a, b, c] : part.triangles) all.triangles.push_back({start + a, start + b, start + c});
}

double diagonal_m(std::span<const Vector3d> points_m) {
  Vector3d low = points_m[0], high = points_m[0];
  for (const Vector3d& point : points_m) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  return (high - low).norm();
}

// Reconstructs the parts between the cuts. Each part extends one radius beyond its cuts.
Result<TriangleMesh> cut_surface(std::span<const Vector3d> points_m, const Vector3d& up, double radius_m,
                                 const std::vector<double>& cuts_m) {
  TriangleMesh all;
  for (size_t i = 0; i <= cuts_m.size(); ++i) {
    std::vector<Vector3d> part;
    for (const Vector3d& point : points_m) {
      const double height = up.dot(point);
      if (i > 0 && height < cuts_m[i - 1] - radius_m) continue;
      if (i < cuts_m.size() && height > cuts_m[i] + radius_m) continue;
      part.push_back(point);
    }
    if (part.empty()) continue;
    SurfaceOptions options = elastic_surface_options();
    options.close_leaks = false;
    options.alpha_radius =
        radius_m / std::max(diagonal_m(part), radius_m);  // the same ball radius for each part
    auto surface = reconstruct_surface(part, options);
    if (!surface) return surface.error();
    append(all, surface->mesh);
  }
  return all;
}

// Returns the height of the cut above `place_m`. The room ends where the filled region above that point ends.
// The cut is made at the height with the fewest points within one radius. This avoids a ceiling, a table top
// or a floor, which would close the parts again.
double cut_height(std::span<const Vector3d> points_m, const Vector3d& up, double radius_m,
                  const FieldShape& filled, const Vector3d& place_m) {
  double ceiling = 0.0;
  for (int march = 0; march < kMaxMarches; ++march) {
    const double inside = -filled.field->sample(place_m + ceiling * up).distance_m;
    if (inside <= 0.0) break;
    ceiling += std::max(inside, 0.1 * radius_m);
  }
  const double from = up.dot(place_m);
  const int steps = std::max(1, static_cast<int>(ceiling / (kHeightStep * radius_m)));
  std::vector<size_t> counts(static_cast<size_t>(steps), 0);
  const auto height_of = [&](size_t step) {
    return from + (static_cast<double>(step) + 0.5) / steps * ceiling;
  };
  for (const Vector3d& point : points_m) {
    for (size_t step = 0; step < counts.size(); ++step) {
      if (std::abs(up.dot(point) - height_of(step)) <= radius_m) ++counts[step];
    }
  }
  return height_of(static_cast<size_t>(std::min_element(counts.begin(), counts.end()) - counts.begin()));
}

}  // namespace

Result<InteriorCollider> interior_collider(std::span<const Vector3d> points_m, const Vector3d& up,
                                           const EmbeddedObjects& stuck) {
  SurfaceOptions options = elastic_surface_options();
  options.close_leaks = false;
  auto surface = reconstruct_surface(points_m, options);
  if (!surface) return surface.error();
  InteriorCollider room{mesh_collider(surface->mesh), surface->mesh};
  const double radius_m = surface->alpha_radius_m;
  if (!(radius_m > 0.0)) return room;  // a convex hull or box was used instead
  std::vector<double> cuts_m;
  std::vector<Vector3d> places = stuck(room.shape);
  for (size_t next = 0, tried = 0; next < places.size() && tried < kMaxCuts; ++tried) {
    std::vector<double> more_m = cuts_m;
    more_m.push_back(cut_height(points_m, up, radius_m, room.shape, places[next]));
    std::sort(more_m.begin(), more_m.end());
    auto open = cut_surface(points_m, up, radius_m, more_m);
    if (!open) return open.error();
    FieldShape opened = mesh_collider(*open);
    std::vector<Vector3d> left = stuck(opened);
    if (left.size() >= places.size()) {
      ++next;
      continue;
    }
    room = {std::move(opened), std::move(*open)};
    cuts_m = std::move(more_m);
    places = std::move(left);
    next = 0;
  }
  if (!cuts_m.empty())
    log_info("environment: closed room opened around the objects in it, %zu cuts", cuts_m.size());
  return room;
}

}  // namespace livegs
