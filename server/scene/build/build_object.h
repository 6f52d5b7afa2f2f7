// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <variant>

#include "analysis/estimate.h"
#include "core/result.h"
#include "livegs/v1/scene.pb.h"
#include "physics/world.h"
#include "scene/build/build_cache.h"
#include "scene/scene_object.h"

namespace livegs {

// Nominal time of a node-substep of an elastic body on one core, for estimates; elastic_bench measures it.
inline constexpr double kNodeSubstep_ms = 26e-6;

struct StaticBodyDescription {
  Pose world_from_object;
  FieldShape shape;  // collision shape for other bodies
  double friction = 0.5, restitution = 0.2;
};

// One object of a scene, ready to be added to a world: drawing data, physical parameters and body.
struct BuiltObject {
  SceneObject drawn;  // id and rest are not set
  Similarity object_from_asset;
  std::vector<Eigen::Vector3d> body_points_m;  // points that the body occupies, object frame
  std::variant<StaticBodyDescription, RigidBodyDescription, ElasticBodyDescription> body;
  // Rigid bodies only: the surface that is cut if the object is fragile, and the fine surface that the
  // kernels lie on.
  std::shared_ptr<const TriangleMesh> cut_mesh, fine_mesh;
  bool standing = false;  // starts asleep
  double build_ms = 0;
};

// The sidecar of an object: the physical parameters that were estimated or edited before.
struct ObjectSidecar {
  std::filesystem::path path;                    // location on disk; empty if the object has no sidecar
  const v1::PhysicsFile* replacement = nullptr;  // replaces the file on disk; null: read the file
};

// Builds an object from its asset, shape or points: surface, facts, parameters and body. No side effects
// other than reading files and filling `cache` with surfaces and shapes, so the objects of a scene are built
// in parallel. `index` selects a colour for uncoloured objects. `field` names the object in errors.
// `settings` belong to the world that the object is added to. `cache`: of earlier builds; null: none.
Result<BuiltObject> build_object(const v1::Object& object, const std::filesystem::path& folder, int index,
                                 const std::string& field, const WorldSettings& settings,
                                 const ObjectSidecar& sidecar = {}, BuildCache* cache = nullptr);
// The same, or a copy of the object if it was built before: the key is its description without pose and
// velocities, its sidecar, the world's settings, and size and time of its file.
Result<BuiltObject> build_cached_object(BuildCache& cache, const v1::Object& object,
                                        const std::filesystem::path& folder, int index,
                                        const std::string& field, const WorldSettings& settings,
                                        const ObjectSidecar& sidecar);
// Sets pose, velocity and visibility to those of `object`, which build_object() does too. The rest of a built
// object does not depend on them.
void place_built(BuiltObject& built, const v1::Object& object);
// Pose of the body's frame for the object's pose.
Pose body_pose(const v1::Object& object, double lift_m);

}  // namespace livegs
