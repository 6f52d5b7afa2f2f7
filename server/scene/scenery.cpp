// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/scenery.h"

#include <algorithm>
#include <cmath>

#include "core/log.h"
#include "gaussian/asset_file.h"
#include "geometry/mesh_io.h"
#include "geometry/reconstruct_surface.h"
#include "geometry/shape_mesh.h"
#include "physics/mesh_collider.h"
#include "scene/scene_values.h"
#include "scene/shape_asset.h"

namespace livegs {
namespace {

const Eigen::Vector3f kSceneryRgb(0.62f, 0.6f, 0.57f);
constexpr double kFloorMargin_m = 0.8;  // how far a drawn floor reaches beyond the objects

Result<Collider> make_collider(const v1::Collider& file, const std::filesystem::path& folder,
                               const std::string& field) {
  Collider collider;
  auto pose = pose_value(file.pose(), field + ".pose");
  if (!pose) return pose.error();
  collider.world_from_collider = *pose;
  if (file.has_friction()) collider.friction = file.friction();
  if (file.has_restitution()) collider.restitution = file.restitution();
  if (file.has_plane()) {
    const Eigen::Vector3d point =
        vector_value(file.plane().point_m(), Eigen::Vector3d::Zero(), field).value();
    const Eigen::Vector3d normal =
        vector_value(file.plane().normal(), Eigen::Vector3d::UnitY(), field).value();
    const Pose plane{point,
                     Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitY(), normal.normalized())};
    collider.world_from_collider = *pose * plane;
    collider.shape = PlaneShape{};
  } else if (file.has_box()) {
    collider.shape = BoxShape{{file.box().size_m(0), file.box().size_m(1), file.box().size_m(2)}};
  } else if (file.has_sphere()) {
    collider.shape = SphereShape{file.sphere().radius_m()};
  } else {
    auto mesh = read_obj(folder / file.mesh());
    if (!mesh) return Error{mesh.error().code, field + ".mesh: " + mesh.error().message};
    collider.shape = mesh_collider(*mesh);
  }
  return collider;
}

void append(GaussianAsset& all, const GaussianAsset& part, const Pose& pose) {
  const size_t start = all.size();
  all.resize(start + part.size());
  for (size_t i = 0; i < part.size(); ++i) {
    all.positions[start + i] = (pose * part.positions[i].cast<double>()).cast<float>();
    all.rotations[start + i] = (pose.orientation.cast<float>() * part.rotations[i]).normalized();
    all.log_scales[start + i] = part.log_scales[i];
    all.opacity_logits[start + i] = part.opacity_logits[i];
    all.sh_dc[start + i] = part.sh_dc[i];
  }
}

// Square tiles of two greys around the objects, fading out towards the rim.
GaussianAsset tiled_floor(double height_m, const Eigen::AlignedBox3d& objects_m) {
  const Eigen::Vector3d centre =
      objects_m.isEmpty() ? Eigen::Vector3d(0, 0, 0) : Eigen::Vector3d(objects_m.center());
  const double reach =
      (objects_m.isEmpty() ? 0.5 : 0.5 * std::max(objects_m.sizes().x(), objects_m.sizes().z())) +
      kFloorMargin_m;
  constexpr int kAcross = 150;  // kernels along an edge
  const double step = 2 * reach / kAcross;
  const double tile = std::max(0.1, std::pow(2.0, std::round(std::log2(reach / 8))));
  GaussianAsset floor;
  for (int row = 0; row < kAcross; ++row) {
    for (int column = 0; column < kAcross; ++column) {
      const double dx = (column + 0.5) * step - reach, dz = (row + 0.5) * step - reach;
      const double rim = 1.0 - std::hypot(dx, dz) / reach;
      if (rim <= 0.0) continue;
      const Eigen::Vector3d point(centre.x() + dx, height_m, centre.z() + dz);
      const bool dark = (static_cast<long>(std::floor(point.x() / tile)) +
                         static_cast<long>(std::floor(point.z() / tile))) &
                        1;
      const size_t i = floor.size();
      floor.resize(i + 1);
      const float width = static_cast<float>(std::log(0.65 * step));
      floor.positions[i] = (point - Eigen::Vector3d(0, 0.1 * step, 0)).cast<float>();
      floor.log_scales[i] = Eigen::Vector3f(width, width + std::log(0.1f), width);
      floor.rotations[i] = Eigen::Quaternionf::Identity();
      const double opacity = std::min(0.97, 3.0 * rim);
      floor.opacity_logits[i] = static_cast<float>(std::log(opacity / (1.0 - opacity)));
      floor.sh_dc[i] = Eigen::Vector3f::Constant(((dark ? 0.46f : 0.54f) - 0.5f) / 0.28209479f);
    }
  }
  return floor;
}

GaussianAsset drawn_colliders(const std::vector<Collider>& colliders, const Eigen::AlignedBox3d& objects_m) {
  GaussianAsset all;
  for (const Collider& collider : colliders) {
    const Pose& pose = collider.world_from_collider;
    if (std::holds_alternative<PlaneShape>(collider.shape)) {
      const Eigen::Vector3d normal = pose.orientation * Eigen::Vector3d::UnitY();
      if (normal.y() > 0.999) append(all, tiled_floor(pose.position_m.y(), objects_m), Pose{});
    } else if (const auto* box = std::get_if<BoxShape>(&collider.shape)) {
      append(all, mesh_asset(box_mesh(box->size_m), kSceneryRgb, 8000), pose);
    } else if (const auto* sphere = std::get_if<SphereShape>(&collider.shape)) {
      append(all, mesh_asset(sphere_mesh(sphere->radius_m, 3), kSceneryRgb), pose);
    }
  }
  return all;
}

}  // namespace

Eigen::AlignedBox3d built_bounds(const std::vector<std::optional<Result<BuiltObject>>>& built) {
  Eigen::AlignedBox3d bounds;
  for (const auto& object : built) {
    const BuiltObject& one = **object;
    const Pose& pose =
        std::visit([](const auto& body) -> const Pose& { return body.world_from_object; }, one.body);
    for (const Eigen::Vector3d& point : one.body_points_m) bounds.extend(pose * point);
  }
  return bounds;
}

Result<Scenery> make_scenery(const v1::Environment& environment, const std::filesystem::path& folder,
                             const Eigen::AlignedBox3d& objects_m) {
  Scenery scenery;
  for (int i = 0; i < environment.colliders_size(); ++i) {
    auto collider =
        make_collider(environment.colliders(i), folder, "environment.colliders[" + std::to_string(i) + "]");
    if (!collider) return collider.error();
    scenery.colliders.push_back(std::move(*collider));
  }
  if (environment.asset().empty()) {
    GaussianAsset drawn = drawn_colliders(scenery.colliders, objects_m);
    if (drawn.size() > 0) scenery.asset = std::make_shared<GaussianAsset>(std::move(drawn));
    return scenery;
  }
  auto file = read_asset(folder / environment.asset());
  if (!file) return Error{file.error().code, "environment.asset: " + file.error().message};
  auto pose = pose_value(environment.pose(), "environment.pose");
  if (!pose) return pose.error();
  auto rotation = up_value(environment.up(), "environment.up");
  if (!rotation) return rotation.error();
  scenery.world_from_object = *pose;
  scenery.object_from_asset.rotation = *rotation;
  if (environment.has_scale()) scenery.object_from_asset.scale = environment.scale();
  auto asset = std::make_shared<GaussianAsset>(std::move(file->asset));
  if (environment.collide()) {
    auto surface =
        reconstruct_surface(body_points(*asset, scenery.object_from_asset), elastic_surface_options());
    if (!surface) return Error{surface.error().code, "environment.asset: " + surface.error().message};
    scenery.colliders.push_back({mesh_collider(surface->mesh), *pose});
  }
  log_info("environment: %zu kernels%s", asset->size(), environment.collide() ? ", collides" : "");
  scenery.asset = std::move(asset);
  return scenery;
}

}  // namespace livegs
