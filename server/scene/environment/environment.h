// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/result.h"
#include "gaussian/gaussian_asset.h"
#include "geometry/triangle_mesh.h"
#include "livegs/v1/scene.pb.h"
#include "physics/collider.h"
#include "scene/build/build_object.h"

namespace livegs {

// The surroundings of a scene: colliders and an asset to draw. If the file names no asset, the colliders are
// drawn: a tiled floor for a level plane, boxes and spheres as given.
struct BuiltEnvironment {
  std::vector<Collider> colliders;  // those of the file, then that of the asset if it collides
  // The surface of the asset's collider, metres, object frame; null if the asset does not collide.
  std::shared_ptr<const TriangleMesh> asset_surface;
  std::shared_ptr<const GaussianAsset> asset;  // null if there is nothing to draw
  Similarity object_from_asset;
  Pose world_from_object;
  // Colliders in which an object must not start, by index, and their fields in the file.
  std::vector<std::pair<size_t, std::string>> solids;
};
// Builds the environment. A mesh that is open or contains an object becomes a wall around its surface. A
// captured room is opened around the objects in it (interior_collider.h). An object that still starts inside
// a solid gets a warning. Precondition: all objects were built successfully. `cache`: as SceneOptions::cache.
Result<std::shared_ptr<const BuiltEnvironment>> build_environment(
    BuildCache* cache, const v1::Environment& environment, const std::filesystem::path& folder,
    std::span<std::optional<Result<BuiltObject>>> built);

// Hands an environment from the thread that builds it to the scene that takes it
// (Scene::replace_environment).
void keep_environment(BuildCache& cache, const v1::Environment& environment,
                      const std::filesystem::path& folder, std::shared_ptr<const BuiltEnvironment> built);
std::shared_ptr<const BuiltEnvironment> kept_environment(BuildCache* cache,
                                                         const v1::Environment& environment,
                                                         const std::filesystem::path& folder);

// Returns the world bounds of all objects in their initial poses, metres.
Eigen::AlignedBox3d built_bounds(std::span<const std::optional<Result<BuiltObject>>> built);

}  // namespace livegs
