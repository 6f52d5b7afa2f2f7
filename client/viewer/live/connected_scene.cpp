// SPDX-License-Identifier: Apache-2.0
#include "viewer/live/connected_scene.h"

namespace livegs {

Result<AssetCache> asset_cache(const std::filesystem::path& folder) {
  if (!folder.empty()) return AssetCache(folder);
  auto own = AssetCache::default_folder();
  if (!own) return own.error();
  return AssetCache(std::move(*own));
}

}  // namespace livegs
