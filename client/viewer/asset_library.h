// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "gaussian/gaussian_asset.h"
#include "stream/asset_cache.h"
#include "stream/session_client.h"

namespace livegs {

// The assets of a session or a recording, decoded, each once however many objects share it. Asking for one starts its fetch
// on a thread of its own, so that a stream's reader never waits for a file. Any thread.
class AssetLibrary {
 public:
  // The bytes of an asset that the cache has not, from `offset` on; several at a time, on any thread.
  using FetchAsset =
      std::function<Result<void>(const std::string& hash, uint64_t bytes, uint64_t offset, const TakeChunk& take)>;
  // The cache outlives the library, and so does what `fetch` needs.
  AssetLibrary(FetchAsset fetch, const AssetCache& cache) : fetch_(std::move(fetch)), cache_(cache) {}
  AssetLibrary(SessionClient& client, const AssetCache& cache)
      : AssetLibrary([&client](const std::string& hash, uint64_t bytes, uint64_t offset,
                               const TakeChunk& take) { return client.fetch_asset(hash, bytes, offset, take); },
                     cache) {}

  using Asset = std::shared_ptr<const GaussianAsset>;
  // The object's own asset and, if it has one, that of its fragments.
  void ask_for(const StreamedObject& object);
  // Waits for it. Precondition: it was asked for.
  Result<Asset> get(const std::string& hash);

  // Over what has arrived.
  struct Totals {
    size_t assets = 0, fetched = 0;
    uint64_t fetched_bytes = 0;
  };
  Totals totals() const;

 private:
  struct Loaded {
    Asset asset;
    uint64_t fetched_bytes = 0;
  };
  void ask_for(const std::string& hash, uint64_t bytes);
  Result<Loaded> load(const std::string& hash, uint64_t bytes);

  const FetchAsset fetch_;
  const AssetCache& cache_;
  mutable std::mutex mutex_;  // guards the two below
  std::map<std::string, std::shared_future<Result<Loaded>>> assets_;
  Totals totals_;
};

}  // namespace livegs
