// SPDX-License-Identifier: Apache-2.0
#include "viewer/assets/load_scene.h"

namespace livegs {

Result<void> load_scene(const JoinedScene& scene, AssetLibrary& assets, SceneView& view) {
  for (const StreamedObject& object : scene.objects) assets.request(object);
  for (const StreamedObject& object : scene.objects) {
    auto asset = assets.get(object.asset_hash);
    if (!asset) return asset.error();
    if (auto added = view.add(object.id, *asset, object.rest, object.environment); !added) {
      return Error{added.error().code, object.name + ": " + added.error().message};
    }
  }
  return {};
}

}  // namespace livegs
