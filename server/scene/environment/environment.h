// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/result.h"
#include "gaussian/gaussian_asset.h"
#include "livegs/v1/scene.pb.h"
#include "physics/collider.h"
#include "scene/build/build_object.h"

namespace livegs {

// What a scene stands in: colliders, and something to draw. An environment without an asset is drawn as its
// colliders: a tiled floor for a level plane, boxes and spheres as they are.
struct BuiltEnvironment {
  std::vector<Collider> colliders;
  std::shared_ptr<const GaussianAsset> asset;  // null when there is nothing to draw
  Similarity object_from_asset;
  Pose world_from_object;
};
// A mesh that is not closed, and one that something stands in, is a wall about its surface; a captured room
// is open for what stands in it (interior_collider.h). An object that starts within what is solid all the
// same gets a warning. Precondition: all objects could be built.
Result<BuiltEnvironment> build_environment(const v1::Environment& environment,
                                           const std::filesystem::path& folder,
                                           std::span<std::optional<Result<BuiltObject>>> built);

// World bounds of all objects as they start.
Eigen::AlignedBox3d built_bounds(std::span<const std::optional<Result<BuiltObject>>> built);

}  // namespace livegs
