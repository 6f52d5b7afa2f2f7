// SPDX-License-Identifier: Apache-2.0
#include "viewer/asset_library.h"

#include "core/assert.h"
#include "gaussian/asset_file.h"

namespace livegs {

void AssetLibrary::ask_for(const StreamedObject& object) {
  ask_for(object.asset_hash, object.asset_bytes);
  if (!object.broken_asset_hash.empty()) ask_for(object.broken_asset_hash, object.broken_asset_bytes);
}

void AssetLibrary::ask_for(const std::string& hash, uint64_t bytes) {
  std::lock_guard lock(mutex_);
  if (assets_.contains(hash)) return;
  assets_.emplace(hash, std::async(std::launch::async, [this, hash, bytes] {
                                       auto loaded = load(hash, bytes);
                                       if (loaded) {
                                         std::lock_guard totals_lock(mutex_);
                                         ++totals_.assets;
                                         totals_.fetched += loaded->fetched_bytes > 0 ? 1 : 0;
                                         totals_.fetched_bytes += loaded->fetched_bytes;
                                       }
                                       return loaded;
                                     }).share());
}

Result<AssetLibrary::Loaded> AssetLibrary::load(const std::string& hash, uint64_t bytes) {
  auto obtained = cache_.obtain(hash, bytes, [&](uint64_t offset, const TakeChunk& take) {
    return fetch_(hash, bytes, offset, take);
  });
  if (!obtained) return obtained.error();
  auto file = decode_asset(obtained->bytes, hash.substr(0, 12) + ".ply");
  if (!file) return file.error();
  return Loaded{std::make_shared<const GaussianAsset>(std::move(file->asset)), obtained->fetched_bytes};
}

Result<AssetLibrary::Asset> AssetLibrary::get(const std::string& hash) {
  std::shared_future<Result<Loaded>> future;
  {
    std::lock_guard lock(mutex_);
    LIVEGS_ASSERT(assets_.contains(hash));
    future = assets_.at(hash);
  }
  const Result<Loaded>& loaded = future.get();
  if (!loaded) return loaded.error();
  return loaded->asset;
}

AssetLibrary::Totals AssetLibrary::totals() const {
  std::lock_guard lock(mutex_);
  return totals_;
}

}  // namespace livegs
