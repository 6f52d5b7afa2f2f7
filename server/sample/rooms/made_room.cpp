// SPDX-License-Identifier: GPL-3.0-or-later
#include "sample/made_room.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sample/rooms/solid_kernels.h"
#include "sample/tools/noise.h"
#include "sample/tools/random.h"

namespace livegs {
namespace {

using namespace sample;
using Eigen::Vector3d;

constexpr double kDeskHeight_m = 0.72, kDeskWidth_m = 1.3, kDeskDepth_m = 0.75, kDeskThickness_m = 0.03;
constexpr double kHalfRoom_m = 1.6, kRoomHeight_m = 2.3;
constexpr double kWallGap_m = 0.0005;  // between a thing and the wall or the thing that it touches
constexpr double kRoomSpacings = 3.0;  // spacing of the kernels of the room, in those of things

struct Plan {
  std::vector<Solid> things;
  bool desk = true;
  double desk_z_m = 0.0;  // of its middle
};

Solid thing(const char* name, SolidShape shape, const Vector3d& size_m, const Vector3d& base_m,
            const Vector3d& rgb, double yaw_deg = 0.0, int pattern = 0) {
  Solid solid;
  solid.name = name;
  solid.shape = shape;
  solid.size_m = size_m;
  solid.base_m = base_m;
  solid.rgb = rgb;
  solid.yaw_rad = yaw_deg * std::numbers::pi / 180;
  solid.pattern = pattern;
  return solid;
}

Plan crowded(uint64_t seed) {
  Plan plan;
  Random random(seed);
  const SolidShape shapes[] = {SolidShape::Box, SolidShape::Cylinder, SolidShape::Ball, SolidShape::Mug,
                               SolidShape::Bottle};
  std::vector<Eigen::Vector3d> discs;  // x, z and radius
  for (int attempt = 0; attempt < 20000 && plan.things.size() < 20; ++attempt) {
    const int i = static_cast<int>(plan.things.size());
    const SolidShape shape = shapes[i % 5];
    Vector3d size(random.uniform(0.05, 0.12), random.uniform(0.05, 0.16), random.uniform(0.05, 0.12));
    if (shape == SolidShape::Ball) size.setConstant(random.uniform(0.05, 0.09));
    if (shape == SolidShape::Mug) size = Vector3d(0.085, 0.1, 0.085);
    if (shape == SolidShape::Bottle) size = Vector3d(0.07, 0.2, 0.07);
    if (shape == SolidShape::Cylinder) size.z() = size.x();
    const double radius = shape == SolidShape::Box ? 0.5 * std::hypot(size.x(), size.z()) : 0.5 * size.x();
    const Vector3d at(random.uniform(-0.52, 0.52), kDeskHeight_m, random.uniform(-0.27, 0.27));
    const double hue = random.uniform(0, 6), yaw = random.uniform(0, 90);
    const Vector3d disc(at.x(), at.z(), radius + (shape == SolidShape::Mug ? 0.03 : 0.0));
    const bool free = std::none_of(discs.begin(), discs.end(), [&](const Vector3d& other) {
      return (other.head<2>() - disc.head<2>()).norm() < other.z() + disc.z() + 0.004;
    });
    if (!free) continue;
    discs.push_back(disc);
    const Vector3d rgb(0.5 + 0.38 * std::cos(hue), 0.5 + 0.38 * std::cos(hue - 2.1),
                       0.5 + 0.38 * std::cos(hue + 2.1));
    plan.things.push_back(thing(("thing" + std::to_string(i + 1)).c_str(), shape, size, at, rgb, yaw, i % 3));
  }
  return plan;
}

Plan plan_of(RoomKind kind, uint64_t seed) {
  using enum SolidShape;
  const double h = kDeskHeight_m;
  Plan plan;
  switch (kind) {
    case RoomKind::Apart:
      plan.things = {thing("carton", Box, {0.16, 0.21, 0.06}, {-0.30, h, -0.10}, {0.75, 0.22, 0.15}, 25, 1),
                     thing("bottle", Bottle, {0.07, 0.22, 0.07}, {0.02, h, -0.16}, {0.85, 0.72, 0.12}),
                     thing("mug", Mug, {0.085, 0.09, 0.085}, {0.27, h, -0.02}, {0.2, 0.35, 0.7}, 110),
                     thing("ball", Ball, {0.075, 0.075, 0.075}, {-0.05, h, 0.15}, {0.75, 0.85, 0.25}, 0, 2),
                     thing("cube", Box, {0.06, 0.06, 0.06}, {0.36, h, 0.2}, {0.3, 0.6, 0.35}, 15, 2)};
      break;
    case RoomKind::Touching:
      plan.things = {
          thing("carton", Box, {0.10, 0.16, 0.08}, {-0.35, h, 0}, {0.75, 0.25, 0.18}, 0, 1),
          thing("packet", Box, {0.08, 0.12, 0.08}, {-0.26 + kWallGap_m, h, 0.01}, {0.25, 0.35, 0.7}, 0, 1),
          thing("tin", Cylinder, {0.08, 0.11, 0.08}, {0.0, h, -0.05}, {0.7, 0.7, 0.72}, 0, 2),
          thing("block", Box, {0.09, 0.09, 0.09}, {0.085 + kWallGap_m, h, -0.05}, {0.7, 0.5, 0.2}, 0, 0),
          thing("ball", Ball, {0.09, 0.09, 0.09}, {0.33, h, 0.1}, {0.8, 0.3, 0.5}, 0, 0),
          thing("mug", Mug, {0.085, 0.1, 0.085}, {0.4175 + kWallGap_m, h, 0.1}, {0.25, 0.6, 0.45}, 90, 0)};
      break;
    case RoomKind::Stacked:
      plan.things = {
          thing("book", Box, {0.22, 0.035, 0.16}, {-0.25, h, 0}, {0.55, 0.16, 0.2}, 12, 0),
          thing("tin", Cylinder, {0.08, 0.1, 0.08}, {-0.25, h + 0.0355, 0}, {0.75, 0.75, 0.7}, 0, 2),
          thing("crate", Box, {0.2, 0.12, 0.15}, {0.22, h, 0.02}, {0.7, 0.52, 0.25}, -8, 1),
          thing("parcel", Box, {0.13, 0.08, 0.1}, {0.21, h + 0.1205, 0.02}, {0.25, 0.42, 0.62}, 20, 1),
          thing("ball", Ball, {0.07, 0.07, 0.07}, {0.21, h + 0.201, 0.02}, {0.8, 0.75, 0.3}, 0, 0)};
      break;
    case RoomKind::Wall:
      plan.desk_z_m = -kHalfRoom_m + 0.5 * kDeskDepth_m;
      plan.things = {
          thing("carton", Box, {0.16, 0.2, 0.1}, {-0.35, h, -kHalfRoom_m + 0.05 + kWallGap_m},
                {0.3, 0.5, 0.65}, 0, 1),
          thing("tin", Cylinder, {0.1, 0.14, 0.1}, {0.0, h, -kHalfRoom_m + 0.05 + kWallGap_m},
                {0.75, 0.4, 0.2}, 0, 2),
          thing("ball", Ball, {0.1, 0.1, 0.1}, {0.25, h, -kHalfRoom_m + 0.05 + kWallGap_m}, {0.4, 0.65, 0.3}),
          thing("clock", Box, {0.22, 0.22, 0.05}, {0.3, h + 0.4, -kHalfRoom_m + 0.025 + kWallGap_m},
                {0.2, 0.2, 0.25}, 0, 2)};
      break;
    case RoomKind::Corner:
      plan.desk = false;
      plan.things = {thing("crate", Box, {0.4, 0.35, 0.3},
                           {-kHalfRoom_m + 0.2 + kWallGap_m, 0, -kHalfRoom_m + 0.15 + kWallGap_m},
                           {0.65, 0.5, 0.28}, 0, 1),
                     thing("bin", Cylinder, {0.26, 0.32, 0.26}, {-kHalfRoom_m + 0.62, 0, -kHalfRoom_m + 0.2},
                           {0.35, 0.4, 0.6}, 0, 2),
                     thing("ball", Ball, {0.22, 0.22, 0.22}, {-kHalfRoom_m + 0.25, 0, -kHalfRoom_m + 0.65},
                           {0.8, 0.35, 0.25})};
      break;
    case RoomKind::Crowded:
      return crowded(seed);
    case RoomKind::Empty:
      break;
  }
  return plan;
}

// Light that reaches a point of the room near the things: a soft dark rim where they stand.
double contact_shade(const Vector3d& point_m, const std::vector<Solid>& things,
                     const std::optional<size_t>& without) {
  double light = 1.0;
  for (size_t i = 0; i < things.size(); ++i) {
    if (i == without) continue;
    const double reach_m = 0.25 * things[i].size_m.norm();
    const double distance_m = std::max(0.0, things[i].distance_m(point_m));
    light *= 1.0 - 0.45 * std::exp(-3.0 * distance_m / reach_m);
  }
  return light;
}

}  // namespace

const char* room_kind_name(RoomKind kind) {
  switch (kind) {
    case RoomKind::Apart:
      return "apart";
    case RoomKind::Touching:
      return "touching";
    case RoomKind::Stacked:
      return "stacked";
    case RoomKind::Wall:
      return "wall";
    case RoomKind::Corner:
      return "corner";
    case RoomKind::Crowded:
      return "crowded";
    case RoomKind::Empty:
      return "empty";
  }
  return "";
}

MadeRoom make_room(RoomKind kind, const MadeRoomOptions& options) {
  const Plan plan = plan_of(kind, options.seed);
  MadeRoom room;
  SolidKernels out;
  const double spacing_m = options.spacing_m, wide_m = kRoomSpacings * spacing_m;

  // The kernels of a thing, without those that another thing covers.
  const auto covered = [&](const Vector3d& point_m, size_t owner, double margin_m) {
    for (size_t i = 0; i < plan.things.size(); ++i)
      if (i + 1 != owner && i != options.without && plan.things[i].distance_m(point_m) < margin_m)
        return true;
    return false;
  };
  const auto add = [&](const std::vector<SurfacePoint>& points, size_t owner, auto&& colour_of) {
    for (const SurfacePoint& point : points) {
      if (covered(point.position_m, owner, 0.25 * spacing_m)) continue;
      out.add(point, colour_of(point), owner);
    }
  };
  const auto wood = [&](const SurfacePoint& p, const Vector3d& rgb, uint64_t seed) {
    const Vector3d at(3 * p.position_m.x(), 30 * p.position_m.y(), 30 * p.position_m.z());
    return Vector3d(rgb * (1 + 0.18 * fractal_noise(at, 3, seed)) *
                    contact_shade(p.position_m, plan.things, options.without));
  };

  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();
  const double half = kHalfRoom_m;
  const auto floor_colour = [&](const SurfacePoint& p) {
    return wood(p, {0.72, 0.66, 0.56}, options.seed + 11);
  };
  const auto wall_colour = [&](const SurfacePoint& p) {
    const double noise = fractal_noise(p.position_m / 0.25, 3, options.seed + 12);
    return Vector3d(Vector3d(0.82, 0.8, 0.75) * (1 + 0.05 * noise) *
                    contact_shade(p.position_m, plan.things, options.without));
  };
  add(rectangle_points(-half * x - half * z, 2 * half * z, 2 * half * x, 2 * wide_m, options.seed + 1), 0,
      floor_colour);
  add(rectangle_points(-half * x - half * z, 2 * half * x, kRoomHeight_m * y, 2 * wide_m, options.seed + 2),
      0, wall_colour);
  add(rectangle_points(-half * x + half * z, -2 * half * z, kRoomHeight_m * y, 2 * wide_m, options.seed + 3),
      0, wall_colour);
  if (plan.desk) {
    Solid top = thing("desk", SolidShape::Box, {kDeskWidth_m, kDeskThickness_m, kDeskDepth_m},
                      {0, kDeskHeight_m - kDeskThickness_m, plan.desk_z_m}, {0.62, 0.45, 0.3});
    const auto desk_colour = [&](const SurfacePoint& p) { return wood(p, top.rgb, options.seed + 13); };
    add(solid_points(top, wide_m, options.seed + 4), 0, desk_colour);
    for (int leg = 0; leg < 4; ++leg) {
      const Vector3d at((leg % 2 ? 1 : -1) * (0.5 * kDeskWidth_m - 0.05), 0,
                        plan.desk_z_m + (leg / 2 ? 1 : -1) * (0.5 * kDeskDepth_m - 0.05));
      add(solid_points(
              thing("leg", SolidShape::Box, {0.05, kDeskHeight_m - kDeskThickness_m, 0.05}, at, top.rgb),
              wide_m, options.seed + 5 + static_cast<uint64_t>(leg)),
          0, desk_colour);
    }
  }
  Eigen::AlignedBox3d all;
  for (size_t i = 0; i < plan.things.size(); ++i) {
    const Solid& solid = plan.things[i];
    room.names.push_back(solid.name);
    // Asset frame: y and z change sign.
    const Eigen::AlignedBox3d box = solid.bounds_m();
    Eigen::AlignedBox3d turned;
    turned.extend(Vector3d(box.min().x(), -box.min().y(), -box.min().z()));
    turned.extend(Vector3d(box.max().x(), -box.max().y(), -box.max().z()));
    room.bounds_m.push_back(turned);
    all.extend(turned);
    if (i == options.without) continue;
    add(solid_points(solid, spacing_m, options.seed + 20 + i), i + 1,
        [&](const SurfacePoint& p) { return solid.colour_at(p, options.seed + 40 + i); });
  }
  room.middle_m = all.isEmpty() ? Vector3d(0, -kDeskHeight_m, 0) : Vector3d(all.center());
  room.owner = std::move(out.owner);
  room.asset = std::move(out.asset);
  return room;
}

}  // namespace livegs
