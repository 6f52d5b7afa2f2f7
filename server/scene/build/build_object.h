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
#include "scene/scene_object.h"

namespace livegs {

struct StaticBodyDescription {
  Pose world_from_object;
  FieldShape shape;  // what others touch
  double friction = 0.5, restitution = 0.2;
};

// One object of a scene, ready to be put into a world: what is drawn, what it is made of, and its body.
struct BuiltObject {
  SceneObject drawn;  // without id and rest
  Similarity object_from_asset;
  std::vector<Eigen::Vector3d> body_points_m;  // what takes up room, object frame
  std::variant<StaticBodyDescription, RigidBodyDescription, ElasticBodyDescription> body;
  // Of a rigid body: what is cut when it is fragile, and the fine surface that its kernels lie on.
  std::shared_ptr<const TriangleMesh> cut_mesh, fine_mesh;
  double build_ms = 0;
};

// What was decided about an object.
struct ObjectSidecar {
  std::filesystem::path path;             // where it is kept; empty: nowhere
  const v1::PhysicsFile* told = nullptr;  // takes the place of what stands there; null leaves that
};

// Asset, shape or points to surface, facts, parameters and body. Pure but for reading files: objects of a
// scene are built in parallel. `index` picks a colour for what has none; `field` is what errors call the
// object; `settings` are the world's it will live in.
Result<BuiltObject> build_object(const v1::Object& object, const std::filesystem::path& folder, int index,
                                 const std::string& field, const WorldSettings& settings,
                                 const ObjectSidecar& sidecar = {});

}  // namespace livegs
