// SPDX-License-Identifier: Apache-2.0
#include "viewer/assets/asset_library.h"

#include <utility>

#include "core/assert.h"
#include "gaussian/asset_file.h"

namespace livegs {

void AssetLibrary::request(const StreamedObject& object) {
  std::string base;
  {
    std::lock_guard lock(mutex_);
    base = std::exchange(newest_[object.name], object.asset_hash);
  }
  request(object.asset_hash, object.asset_bytes, object.name, base);
  if (!object.broken_asset_hash.empty())
    request(object.broken_asset_hash, object.broken_asset_bytes, object.name + ", broken", object.asset_hash);
}

void AssetLibrary::request(const std::string& hash, uint64_t bytes, const std::string& object,
                           const std::string& base) {
  std::lock_guard lock(mutex_);
  if (assets_.contains(hash)) return;
  auto asked = std::make_shared<RequestedAsset>();
  asked->object = object;
  asked->bytes = bytes;
  assets_.emplace(hash, asked);
  in_order_.push_back(asked);
  threads_.push_back(std::async(std::launch::async, [this, hash, bytes, base, asked] {
    auto loaded = load(hash, bytes, base, *asked);
    std::lock_guard done(mutex_);
    if (loaded) {
      ++totals_.assets;
      totals_.fetched += loaded->fetched_bytes > 0 ? 1 : 0;
      totals_.fetched_bytes += loaded->fetched_bytes;
      asked->arrived_bytes = bytes;
    }
    asked->loaded.emplace(std::move(loaded));
    asked->part.reset();
    ++asked->step;
    arrived_.notify_all();
  }));
}

Result<AssetLibrary::Loaded> AssetLibrary::load(const std::string& hash, uint64_t bytes,
                                                const std::string& base, RequestedAsset& asked) {
  AssetCache::Progress progress;
  if (shows_parts_) {
    // Parts double in size, since each part costs the renderer as much as it holds.
    progress = [this, &asked, shown = size_t{0}](const ProgressiveDecoder& so_far) mutable {
      const size_t come = so_far.arrived() + so_far.arrived_harmonics();
      if (come < 2 * shown || so_far.complete()) return;
      shown = come;
      keep_part(so_far, asked);
    };
  }
  const auto counted = [&](AssetCache::Fetch fetch) -> AssetCache::Fetch {
    return [this, &asked, fetch = std::move(fetch)](uint64_t from, const TakeChunk& take) {
      return fetch(from,
                   [&](uint64_t offset, uint64_t total, std::span<const std::byte> chunk) -> Result<void> {
                     if (auto taken = take(offset, total, chunk); !taken) return taken;
                     std::lock_guard lock(mutex_);
                     asked.arrived_bytes = offset + chunk.size();
                     return {};
                   });
    };
  };
  std::vector<AssetCache::Fetch> sources;
  if (auto stored = find_stored_ ? find_stored_(hash, bytes) : nullptr)
    sources.push_back(counted(std::move(stored)));
  sources.push_back(
      counted([&](uint64_t from, const TakeChunk& take) { return fetch_(hash, bytes, from, take); }));
  AssetCache::Edit edit;
  if (fetch_edit_ && !base.empty()) {
    edit.base = [&]() -> Asset {
      auto loaded = get(base);
      return loaded ? *loaded : nullptr;
    };
    edit.fetch = [&](uint64_t from, const TakeChunk& take) {
      return fetch_edit_(base, hash, bytes, from, take);
    };
  }
  auto obtained = cache_.obtain(hash, bytes, sources, progress, stop_, edit);
  if (!obtained) return obtained.error();
  if (stop_.stop_requested())
    return Error{ErrorCode::Unavailable, "asset " + hash.substr(0, 12) + ": the fetch was cancelled"};
  auto file = decode_asset(obtained->bytes, hash.substr(0, 12) + ".ply");
  if (!file) return file.error();
  return Loaded{std::make_shared<const GaussianAsset>(std::move(file->asset)), obtained->fetched_bytes};
}

void AssetLibrary::keep_part(const ProgressiveDecoder& so_far, RequestedAsset& asked) {
  auto part = std::make_shared<const AssetPart>(so_far.part());
  if (part->indices.empty()) return;
  std::lock_guard lock(mutex_);
  asked.part = std::move(part);
  ++asked.step;
  arrived_.notify_all();
}

Result<AssetLibrary::Asset> AssetLibrary::get(const std::string& hash) {
  std::unique_lock lock(mutex_);
  LIVEGS_ASSERT(assets_.contains(hash));
  const auto asked = assets_.at(hash);
  arrived_.wait(lock, [&] { return asked->loaded.has_value(); });
  if (!*asked->loaded) return asked->loaded->error();
  return (*asked->loaded)->asset;
}

Result<AssetLibrary::Arrived> AssetLibrary::wait_for_more(const std::string& hash, size_t than_step) {
  std::unique_lock lock(mutex_);
  LIVEGS_ASSERT(assets_.contains(hash));
  const auto asked = assets_.at(hash);
  arrived_.wait(lock, [&] { return asked->step > than_step; });
  if (!asked->loaded) {
    // The part owns the kernels.
    return Arrived{Asset(asked->part, &asked->part->asset), asked->part, asked->step};
  }
  if (!*asked->loaded) return asked->loaded->error();
  return Arrived{(*asked->loaded)->asset, nullptr, asked->step};
}

bool AssetLibrary::has_more(const std::string& hash, size_t than_step) const {
  std::lock_guard lock(mutex_);
  const auto asked = assets_.find(hash);
  return asked != assets_.end() && asked->second->step > than_step;
}

AssetLibrary::Progress AssetLibrary::progress() const {
  std::lock_guard lock(mutex_);
  Progress progress;
  progress.assets = in_order_.size();
  for (const auto& one : in_order_) {
    const bool ready = one->loaded && *one->loaded;
    progress.ready += ready;
    progress.bytes += one->bytes;
    progress.arrived_bytes += one->arrived_bytes;
    if (ready || !progress.object.empty()) continue;
    progress.object = one->object;
    progress.object_bytes = one->bytes;
    progress.object_arrived_bytes = one->arrived_bytes;
  }
  return progress;
}

AssetLibrary::Totals AssetLibrary::totals() const {
  std::lock_guard lock(mutex_);
  return totals_;
}

}  // namespace livegs
