// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/environment/environment.h"

#include <algorithm>
#include <cmath>

#include "core/log.h"
#include "core/math/rotation_between.h"
#include "core/text/format_text.h"
#include "gaussian/asset_file.h"
#include "geometry/mesh/mesh_io.h"
#include "geometry/mesh/mesh_topology.h"
#include "geometry/mesh/weld_vertices.h"
#include "geometry/reconstruct_surface.h"
#include "geometry/surface/shape_mesh.h"
#include "parts/labelled_room.h"
#include "prepare/mesh_collider.h"
#include "scene/build/build_cache.h"
#include "scene/build/shape_asset.h"
#include "scene/environment/environment_frame.h"
#include "scene/environment/interior_collider.h"
#include "scene/values/scene_values.h"

namespace livegs {
namespace {

const Eigen::Vector3f kEnvironmentRgb(0.62f, 0.6f, 0.57f);
constexpr double kFloorMargin_m = 0.8;  // distance that a drawn floor extends beyond the objects
// Fraction of an object's points inside a solid above which the object is embedded in it. Objects on a rough
// floor have a few points below its surface.
constexpr double kInsideShare = 0.75;
constexpr size_t kSampledPoints = 400;
// Minimum volume of a solid relative to its length cubed. A mesh below is a surface, such as one with every
// face in both orientations.
constexpr double kMinSolidVolume = 1e-6;

struct Standing {
  SceneObject* drawn;
  std::vector<Eigen::Vector3d> points_m;  // world frame, initial pose

  Eigen::Vector3d centre_m() const {
    Eigen::AlignedBox3d bounds;
    for (const Eigen::Vector3d& point : points_m) bounds.extend(point);
    return bounds.center();
  }
  bool is_in(const Collider& collider) const {
    const auto inside = std::count_if(points_m.begin(), points_m.end(), [&](const Eigen::Vector3d& point) {
      return sample_surface(collider, point).distance_m < 0.0;
    });
    return static_cast<double>(inside) >= kInsideShare * static_cast<double>(points_m.size());
  }
};

const Pose& pose_of(const BuiltObject& built) {
  return std::visit([](const auto& body) -> const Pose& { return body.world_from_object; }, built.body);
}

std::vector<Standing> standing_objects(std::span<std::optional<Result<BuiltObject>>> built) {
  std::vector<Standing> all;
  for (auto& object : built) {
    BuiltObject& one = **object;
    Standing standing{&one.drawn, {}};
    const size_t step = one.body_points_m.size() / kSampledPoints + 1;
    for (size_t i = 0; i < one.body_points_m.size(); i += step) {
      standing.points_m.push_back(pose_of(one) * one.body_points_m[i]);
    }
    if (!standing.points_m.empty()) all.push_back(std::move(standing));
  }
  return all;
}

const Standing* first_in(const Collider& collider, std::span<const Standing> standing) {
  const auto found = std::find_if(standing.begin(), standing.end(),
                                  [&](const Standing& one) { return one.is_in(collider); });
  return found == standing.end() ? nullptr : &*found;
}

void warn_of_stuck(const Collider& collider, std::span<const Standing> standing, const std::string& field) {
  for (const Standing& one : standing) {
    if (!one.is_in(collider)) continue;
    one.drawn->warnings.push_back("pose: starts inside " + field +
                                  " and is pushed out; move the object or the collider");
  }
}

// Sets the shape of a collider from a mesh. Precondition: the collider's pose is set.
Result<void> shape_mesh(const TriangleMesh& file, std::span<const Standing> standing,
                        const std::string& field, Collider& collider) {
  const TriangleMesh mesh = weld_vertices(file);
  const double longest_m = mesh_bounds_m(mesh).sizes().maxCoeff();
  double area_m2 = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    area_m2 +=
        0.5 * (mesh.vertices_m[b] - mesh.vertices_m[a]).cross(mesh.vertices_m[c] - mesh.vertices_m[a]).norm();
  }
  if (!(area_m2 > 0.0))
    return invalid_data(field + ": all triangles have zero area; export the mesh with its faces");
  const std::string wall =
      format_text("a wall of %.2g mm around its surface", 1e3 * wall_thickness_m(longest_m));
  if (const size_t open = open_edge_count(mesh); open > 0) {
    log_info(
        "%s: %zu edges are open or join faces of opposite orientation, using %s; close the mesh to make it "
        "solid",
        field.c_str(), open, wall.c_str());
    collider.shape = wall_collider(mesh);
    return {};
  }
  if (std::abs(signed_volume_m3(mesh)) < kMinSolidVolume * longest_m * longest_m * longest_m) {
    log_info("%s: encloses no volume, using %s", field.c_str(), wall.c_str());
    collider.shape = wall_collider(mesh);
    return {};
  }
  collider.shape = mesh_collider(mesh);
  if (const Standing* one = first_in(collider, standing)) {
    log_info("%s: contains %s, so it is treated as a room, using %s", field.c_str(), one->drawn->name.c_str(),
             wall.c_str());
    collider.shape = wall_collider(mesh);
  }
  return {};
}

Result<Collider> make_collider(const v1::Collider& file, const std::filesystem::path& folder,
                               std::span<const Standing> standing, const std::string& field) {
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
    const Pose plane{point, rotation_between(Eigen::Vector3d::UnitY(), normal)};
    collider.world_from_collider = *pose * plane;
    collider.shape = PlaneShape{};
  } else if (file.has_box()) {
    collider.shape = BoxShape{{file.box().size_m(0), file.box().size_m(1), file.box().size_m(2)}};
  } else if (file.has_sphere()) {
    collider.shape = SphereShape{file.sphere().radius_m()};
  } else {
    auto mesh = read_obj(folder / file.mesh());
    if (!mesh) return Error{mesh.error().code, field + ".mesh: " + mesh.error().message};
    if (auto shaped = shape_mesh(*mesh, standing, field + ".mesh", collider); !shaped) return shaped.error();
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

// Makes square tiles of two greys around the objects, which fade out towards the rim.
GaussianAsset tiled_floor(double height_m, const Eigen::AlignedBox3d& objects_m) {
  const Eigen::Vector3d centre =
      objects_m.isEmpty() ? Eigen::Vector3d(0, 0, 0) : Eigen::Vector3d(objects_m.center());
  const double reach =
      (objects_m.isEmpty() ? 0.5 : 0.5 * std::max(objects_m.sizes().x(), objects_m.sizes().z())) +
      kFloorMargin_m;
  constexpr int kAcross = 150;  // number of kernels along an edge
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
      append(all, mesh_asset(box_mesh(box->size_m), kEnvironmentRgb, 8000), pose);
    } else if (const auto* sphere = std::get_if<SphereShape>(&collider.shape)) {
      append(all, mesh_asset(sphere_mesh(sphere->radius_m, 3), kEnvironmentRgb), pose);
    }
  }
  return all;
}

}  // namespace

Eigen::AlignedBox3d built_bounds(std::span<const std::optional<Result<BuiltObject>>> built) {
  Eigen::AlignedBox3d bounds;
  for (const auto& object : built) {
    const BuiltObject& one = **object;
    for (const Eigen::Vector3d& point : one.body_points_m) bounds.extend(pose_of(one) * point);
  }
  return bounds;
}

namespace {

// The asset without the things that were taken out of it, with its axis and unit.
struct DrawnRoom {
  GaussianAsset asset;
  AssetFrame frame;
};
Result<DrawnRoom> drawn_room(const v1::Environment& environment, const std::filesystem::path& folder) {
  if (environment.taken_size() == 0) {
    auto file = read_asset(folder / environment.asset());
    if (!file) return Error{file.error().code, "environment.asset: " + file.error().message};
    return DrawnRoom{std::move(file->asset), environment_frame(environment, std::move(file->frame))};
  }
  auto room = read_labelled_room(folder / environment.labels());
  if (!room) return Error{room.error().code, "environment.labels: " + room.error().message};
  const std::vector<uint32_t> taken(environment.taken().begin(), environment.taken().end());
  return DrawnRoom{room_without(*room, taken), environment_frame(environment, folder)};
}

Result<BuiltEnvironment> make_environment(const v1::Environment& environment,
                                          const std::filesystem::path& folder,
                                          std::span<const Standing> standing,
                                          std::span<const std::optional<Result<BuiltObject>>> built) {
  BuiltEnvironment result;
  for (int i = 0; i < environment.colliders_size(); ++i) {
    const std::string field = "environment.colliders[" + std::to_string(i) + "]";
    auto collider = make_collider(environment.colliders(i), folder, standing, field);
    if (!collider) return collider.error();
    if (environment.colliders(i).shape_case() == v1::Collider::kMesh)
      result.solids.emplace_back(result.colliders.size(), field);
    result.colliders.push_back(std::move(*collider));
  }
  if (environment.asset().empty()) {
    GaussianAsset drawn = drawn_colliders(result.colliders, built_bounds(built));
    if (drawn.size() > 0) result.asset = std::make_shared<GaussianAsset>(std::move(drawn));
    return result;
  }
  auto room = drawn_room(environment, folder);
  if (!room) return room.error();
  auto pose = pose_value(environment.pose(), "environment.pose");
  if (!pose) return pose.error();
  auto rotation = up_value(room->frame.up_axis, "environment.up");
  if (!rotation) return rotation.error();
  result.world_from_object = *pose;
  result.object_from_asset.rotation = *rotation;
  result.object_from_asset.scale = room->frame.metres_per_unit;
  auto asset = std::make_shared<GaussianAsset>(std::move(room->asset));
  if (environment.collide()) {
    const auto stuck = [&](const FieldShape& shape) {
      std::vector<Eigen::Vector3d> places;
      for (const Standing& one : standing) {
        if (one.is_in({shape, *pose})) places.push_back(pose->inverse() * one.centre_m());
      }
      return places;
    };
    auto interior = interior_collider(body_points(*asset, result.object_from_asset),
                                      pose->orientation.conjugate() * Eigen::Vector3d::UnitY(), stuck);
    if (!interior) return Error{interior.error().code, "environment.asset: " + interior.error().message};
    result.solids.emplace_back(result.colliders.size(), "environment.asset");
    result.colliders.push_back({std::move(interior->shape), *pose});
    result.asset_surface = std::make_shared<const TriangleMesh>(std::move(interior->surface));
  }
  log_info("environment: %zu kernels%s", asset->size(), environment.collide() ? ", collides" : "");
  result.asset = std::move(asset);
  return result;
}

// The files and fields that an environment is built from.
std::string key_of(const v1::Environment& environment, const std::filesystem::path& folder) {
  std::string key = "environment " + environment.SerializeAsString() + '\n';
  for (const std::string* file : {&environment.asset(), &environment.labels()}) {
    if (!file->empty()) key += BuildCache::stamp_of(folder / *file);
  }
  for (const v1::Collider& collider : environment.colliders()) {
    if (collider.shape_case() == v1::Collider::kMesh) key += BuildCache::stamp_of(folder / collider.mesh());
  }
  return key;
}

size_t bytes_of(const BuiltEnvironment& built) {
  return built.asset ? BuildCache::kKernelBytes * built.asset->size() : 0;
}

// The objects decide how a room is opened and how large a drawn floor is.
std::string key_of(std::span<const Standing> standing) {
  std::string bytes;
  for (const Standing& one : standing)
    bytes.append(reinterpret_cast<const char*>(one.points_m.data()),
                 one.points_m.size() * sizeof(Eigen::Vector3d));
  return "\naround " + std::to_string(bytes.size()) + " " + std::to_string(std::hash<std::string>()(bytes));
}

}  // namespace

Result<std::shared_ptr<const BuiltEnvironment>> build_environment(
    BuildCache* cache, const v1::Environment& environment, const std::filesystem::path& folder,
    std::span<std::optional<Result<BuiltObject>>> built) {
  const std::vector<Standing> standing = standing_objects(built);
  const std::string key = cache ? key_of(environment, folder) + key_of(standing) : "";
  auto made = cache ? cache->find<BuiltEnvironment>(key) : nullptr;
  if (!made) {
    auto fresh = make_environment(environment, folder, standing, built);
    if (!fresh) return fresh.error();
    made = std::make_shared<const BuiltEnvironment>(std::move(*fresh));
    if (cache) cache->keep(key, made, bytes_of(*made));
  }
  for (const auto& [collider, field] : made->solids)
    warn_of_stuck(made->colliders[collider], standing, field);
  return made;
}

void keep_environment(BuildCache& cache, const v1::Environment& environment,
                      const std::filesystem::path& folder, std::shared_ptr<const BuiltEnvironment> built) {
  const size_t bytes = bytes_of(*built);
  cache.keep(key_of(environment, folder), std::move(built), bytes);
}

std::shared_ptr<const BuiltEnvironment> kept_environment(BuildCache* cache,
                                                         const v1::Environment& environment,
                                                         const std::filesystem::path& folder) {
  if (!cache) return nullptr;
  return cache->find<BuiltEnvironment>(key_of(environment, folder));
}

}  // namespace livegs
