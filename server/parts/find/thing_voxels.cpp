// SPDX-License-Identifier: GPL-3.0-or-later
#include "parts/find/thing_voxels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel_for.h"

namespace livegs {
namespace {

constexpr double kVoxel_points = 1.25;      // edge in distances of points; below 1 surfaces fall apart
constexpr uint32_t kMinVoxelPoints = 3;     // fewer are noise of single views
constexpr double kMinHeight_voxels = 1.33;  // least height above a support
constexpr double kFootDeviations = 3.0;     // the same in standard deviations of the plane
constexpr double kWallGap_voxels = 1.0;     // least distance from a wall
constexpr double kTouch_voxels = 3.0;       // of a support or a wall by a thing
constexpr double kThrough_voxels = 2.0;     // depth difference beyond which a view sees through a voxel
constexpr size_t kMinThingVoxels = 40;  // smaller things have less than 8 voxels across and no reliable shape

// A leg or a body of furniture: it is below a support, and no view sees through the space between its highest
// voxel and the support.
bool carries_support(const Thing& thing, const ThingVoxels& found, const RoomPlanes& planes,
                     std::span<const RoomView> views, std::span<const ViewRays> rays,
                     const PartScale& scale) {
  const VoxelSet& voxels = found.voxels;
  for (const RoomPlane& plane : planes.supports) {
    double top_m = -std::numeric_limits<double>::infinity();
    Eigen::Vector3d top = Eigen::Vector3d::Zero();
    for (uint32_t i : thing.voxels) {
      const Eigen::Vector3d p = voxels[i].position_m.cast<double>();
      if (plane.height_m(p) > top_m) top_m = plane.height_m(p), top = p;
    }
    if (top_m > 0 || !plane.region.contains(top)) continue;
    size_t steps = 0, free = 0;
    for (double rise_m = kThrough_voxels * scale.voxel_m; top_m + rise_m < -kThrough_voxels * scale.voxel_m;
         rise_m += scale.voxel_m, ++steps)
      for (size_t v = 0; v < views.size(); ++v) {
        ViewRays::Hit hit;
        if (!rays[v].project(top + rise_m * plane.normal, hit)) continue;
        const float depth_m =
            views[v].kernels.depth_m[static_cast<size_t>(hit.y) * views[v].camera.width + hit.x];
        if (depth_m - hit.depth_m > kThrough_voxels * scale.voxel_m) {
          ++free;
          break;
        }
      }
    if (2 * free <= steps) return true;
  }
  return false;
}

}  // namespace

double PartScale::foot_m(const RoomPlane& plane) const {
  return std::max(kMinHeight_voxels * voxel_m, kFootDeviations * plane.deviation_m);
}

PartScale part_scale(std::span<const ViewPoint> points, int stride) {
  PartScale scale;
  if (points.empty()) return scale;
  std::vector<float> footprints;
  for (const ViewPoint& point : points) footprints.push_back(point.footprint_m);
  const auto middle = footprints.begin() + static_cast<std::ptrdiff_t>(footprints.size() / 2);
  std::nth_element(footprints.begin(), middle, footprints.end());
  scale.footprint_m = *middle;
  scale.voxel_m = kVoxel_points * stride * scale.footprint_m;
  return scale;
}

uint32_t support_below(const RoomPlanes& planes, const Eigen::Vector3d& point_m, double margin_m) {
  for (uint32_t s = 0; s < planes.supports.size(); ++s)  // highest first
    if (planes.supports[s].height_m(point_m) > -margin_m && planes.supports[s].region.contains(point_m))
      return s;
  return kNoVoxel;
}

ThingVoxels thing_voxels(std::span<const ViewPoint> points, std::span<const RoomView> views,
                         const RoomPlanes& planes, const PartScale& scale) {
  const auto position = [&](uint32_t i) { return points[i].position_m.cast<double>().eval(); };
  std::vector<uint8_t> over(points.size(), 0);
  parallel_for(points.size(), 4096, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const Eigen::Vector3d p = position(static_cast<uint32_t>(i));
      const uint32_t s = support_below(planes, p, scale.foot_m(planes.supports.front()));
      if (s == kNoVoxel || planes.supports[s].height_m(p) < scale.foot_m(planes.supports[s])) continue;
      over[i] = std::none_of(planes.walls.begin(), planes.walls.end(), [&](const RoomPlane& wall) {
        return wall.height_m(p) <
               std::max(kWallGap_voxels * scale.voxel_m, kFootDeviations * wall.deviation_m);
      });
    }
  });
  std::vector<uint32_t> chosen;
  for (uint32_t i = 0; i < points.size(); ++i)
    if (over[i]) chosen.push_back(i);
  ThingVoxels found{VoxelSet(points, chosen, scale.voxel_m, kMinVoxelPoints), {}, {}};
  VoxelSet& voxels = found.voxels;

  // Free space: a voxel is kept if at least as many views meet it as see through it.
  std::vector<uint8_t> solid(voxels.size(), 0);
  std::vector<ViewRays> rays;
  for (const RoomView& view : views) rays.emplace_back(view.camera);
  parallel_for(voxels.size(), 256, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      int met = 0, through = 0;
      for (size_t v = 0; v < views.size(); ++v) {
        ViewRays::Hit hit;
        if (!rays[v].project(voxels[i].position_m.cast<double>(), hit)) continue;
        const double behind_m =
            views[v].kernels.depth_m[static_cast<size_t>(hit.y) * views[v].camera.width + hit.x] -
            hit.depth_m;
        met += std::abs(behind_m) <= kThrough_voxels * scale.voxel_m;
        through += behind_m > kThrough_voxels * scale.voxel_m;
      }
      solid[i] = met >= through;
    }
  });
  voxels.keep(solid);

  found.support.resize(voxels.size());
  for (size_t i = 0; i < voxels.size(); ++i)
    found.support[i] = support_below(planes, voxels[i].position_m.cast<double>(), scale.voxel_m);
  size_t count = 0;
  const std::vector<uint32_t> component = connected_voxels(voxels, count);
  std::vector<Thing> things(count);
  for (uint32_t i = 0; i < voxels.size(); ++i) things[component[i]].voxels.push_back(i);
  for (Thing& thing : things) {
    if (thing.voxels.size() < kMinThingVoxels) continue;
    bool furniture = carries_support(thing, found, planes, views, rays, scale);
    for (uint32_t i : thing.voxels) {
      const Eigen::Vector3d p = voxels[i].position_m.cast<double>();
      if (found.support[i] != kNoVoxel &&
          planes.supports[found.support[i]].height_m(p) <
              kTouch_voxels * scale.voxel_m + scale.foot_m(planes.supports[found.support[i]]))
        thing.support = found.support[i];
      for (size_t w = 0; w < planes.walls.size(); ++w)
        if (planes.walls[w].height_m(p) < (kTouch_voxels + kWallGap_voxels) * scale.voxel_m) thing.wall = w;
    }
    if (furniture || (!thing.support && !thing.wall)) continue;
    found.things.push_back(std::move(thing));
  }
  return found;
}

}  // namespace livegs
