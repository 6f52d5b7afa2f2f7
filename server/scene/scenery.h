// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "core/result.h"
#include "gaussian/gaussian_asset.h"
#include "livegs/v1/scene.pb.h"
#include "physics/collider.h"
#include "scene/build_object.h"

namespace livegs {

// What a scene stands in: colliders, and something to draw. An environment without an asset is drawn as its
// colliders: a tiled floor for a level plane, boxes and spheres as they are.
struct Scenery {
  std::vector<Collider> colliders;
  std::shared_ptr<const GaussianAsset> asset;  // null when there is nothing to draw
  Similarity object_from_asset;
  Pose world_from_object;
};
Result<Scenery> make_scenery(const v1::Environment& environment, const std::filesystem::path& folder,
                             const Eigen::AlignedBox3d& objects_m);

// World bounds of all objects as they start.
Eigen::AlignedBox3d built_bounds(const std::vector<std::optional<Result<BuiltObject>>>& built);

}  // namespace livegs
