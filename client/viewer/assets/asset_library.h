// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "gaussian/gaussian_asset.h"
#include "stream/received/asset_cache.h"
#include "stream/session/session_client.h"

namespace livegs {

// Decoded assets of a session or a recording, each loaded once for all objects that share it. A request
// starts the fetch on its own thread, so that the reader of a stream never waits for a file. Any thread.
class AssetLibrary {
 public:
  // Fetches an asset that is not in the cache, from `offset` on; concurrent calls on any thread.
  using FetchAsset = std::function<Result<void>(const std::string& hash, uint64_t bytes, uint64_t offset,
                                                const TakeChunk& take)>;
  // The cache and the dependencies of `fetch` must outlive the library. The destructor waits for running
  // fetches; request `stop`, which `fetch` must observe as well, to end them early.
  AssetLibrary(FetchAsset fetch, const AssetCache& cache, std::stop_token stop = {})
      : fetch_(std::move(fetch)), cache_(cache), stop_(std::move(stop)) {}
  // Fetches assets from the store that the server names, and from the server if that fails.
  AssetLibrary(SessionClient& client, const AssetCache& cache, std::stop_token stop = {})
      : AssetLibrary(
            [&client](const std::string& hash, uint64_t bytes, uint64_t offset, const TakeChunk& take) {
              return client.fetch_asset(hash, bytes, offset, take);
            },
            cache, std::move(stop)) {
    fetch_edit_ = [&client](const std::string& base, const std::string& hash, uint64_t bytes, uint64_t offset,
                            const TakeChunk& take) {
      return client.fetch_asset(hash, bytes, offset, take, base);
    };
    find_stored_ = [&client](const std::string& hash, uint64_t bytes) {
      return client.stored_asset(hash, bytes);
    };
  }

  using Asset = std::shared_ptr<const GaussianAsset>;
  // Makes partially received assets available before they are complete.
  void show_parts() { shows_parts_ = true; }
  // Requests the object's asset and, if present, the asset of its fragments. If an object of this name had
  // another asset, the server may send the difference only.
  void request(const StreamedObject& object);
  // Waits until the asset is loaded. Precondition: it was requested.
  Result<Asset> get(const std::string& hash);

  // The part of an asset received so far.
  struct Arrived {
    Asset asset;
    std::shared_ptr<const AssetPart> part;  // owner of the kernels of `asset`; null: it is complete
    size_t step = 0;                        // increases with the received data
  };
  // Waits for more data than at `than_step`; 0 means none. Waits for the complete asset unless parts are
  // shown. Precondition: it was requested.
  Result<Arrived> wait_for_more(const std::string& hash, size_t than_step);
  // Whether wait_for_more() would return at once.
  bool has_more(const std::string& hash, size_t than_step) const;

  // Totals of the received assets.
  struct Totals {
    size_t assets = 0, fetched = 0;
    uint64_t fetched_bytes = 0;
  };
  Totals totals() const;

  // Progress of the requested assets.
  struct Progress {
    size_t assets = 0, ready = 0;
    uint64_t bytes = 0,
             arrived_bytes = 0;  // of all assets; those of a cached asset count once it is read
    // Name of an object whose asset is the first in request order that is not ready. Empty when all are
    // ready.
    std::string object;
    uint64_t object_bytes = 0, object_arrived_bytes = 0;
  };
  Progress progress() const;

 private:
  struct Loaded {
    Asset asset;
    uint64_t fetched_bytes = 0;
  };
  // Guarded by the mutex; shared with the fetching thread.
  struct RequestedAsset {
    std::string object;  // an object that uses it
    uint64_t bytes = 0, arrived_bytes = 0;
    std::optional<Result<Loaded>> loaded;
    std::shared_ptr<const AssetPart> part;
    size_t step = 0;  // as in Arrived
  };
  // `base`: hash of an asset that was requested before; empty: none.
  void request(const std::string& hash, uint64_t bytes, const std::string& object, const std::string& base);
  Result<Loaded> load(const std::string& hash, uint64_t bytes, const std::string& base,
                      RequestedAsset& asked);
  void keep_part(const ProgressiveDecoder& so_far, RequestedAsset& asked);

  const FetchAsset fetch_;
  // An asset's fetch from a store; null if no store has it.
  std::function<AssetCache::Fetch(const std::string& hash, uint64_t bytes)> find_stored_;
  // Fetches an asset as an edit of `base`; null if no source has edits.
  std::function<Result<void>(const std::string& base, const std::string& hash, uint64_t bytes,
                             uint64_t offset, const TakeChunk& take)>
      fetch_edit_;
  const AssetCache& cache_;
  const std::stop_token stop_;
  bool shows_parts_ = false;
  mutable std::mutex mutex_;  // guards all below
  std::condition_variable arrived_;
  Totals totals_;
  std::map<std::string, std::shared_ptr<RequestedAsset>> assets_;
  std::map<std::string, std::string> newest_;                    // hash by name of the object
  std::vector<std::shared_ptr<const RequestedAsset>> in_order_;  // in order of the requests
  std::vector<std::future<void>> threads_;                       // last: they use all members above
};

}  // namespace livegs
