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

// The assets of a session or a recording, decoded, each once however many objects share it. Asking for one
// starts its fetch on a thread of its own, so that a stream's reader never waits for a file. Any thread.
class AssetLibrary {
 public:
  // The bytes of an asset that the cache has not, from `offset` on; several at a time, on any thread.
  using FetchAsset = std::function<Result<void>(const std::string& hash, uint64_t bytes, uint64_t offset,
                                                const TakeChunk& take)>;
  // The cache outlives the library, and so does what `fetch` needs. Its end waits for fetches that are under
  // way: request `stop`, which `fetch` heeds as well, where nobody needs them any more.
  AssetLibrary(FetchAsset fetch, const AssetCache& cache, std::stop_token stop = {})
      : fetch_(std::move(fetch)), cache_(cache), stop_(std::move(stop)) {}
  AssetLibrary(SessionClient& client, const AssetCache& cache, std::stop_token stop = {})
      : AssetLibrary(
            [&client](const std::string& hash, uint64_t bytes, uint64_t offset, const TakeChunk& take) {
              return client.fetch_asset(hash, bytes, offset, take);
            },
            cache, std::move(stop)) {}

  using Asset = std::shared_ptr<const GaussianAsset>;
  // From now on, what has come of assets that are asked for can be had before they are whole.
  void show_parts() { shows_parts_ = true; }
  // The object's own asset and, if it has one, that of its fragments.
  void request(const StreamedObject& object);
  // Waits for it. Precondition: it was asked for.
  Result<Asset> get(const std::string& hash);

  // As much of it as has come.
  struct Arrived {
    Asset asset;
    std::shared_ptr<const AssetPart> part;  // of which `asset` is the kernels; null: it is whole
    size_t step = 0;                        // grows with what has come
  };
  // Waits until there is more than of this step, 0 being nothing; until all is there unless parts are shown.
  // Precondition: it was asked for.
  Result<Arrived> wait_for_more(const std::string& hash, size_t than_step);
  // Whether that would return at once.
  bool has_more(const std::string& hash, size_t than_step) const;

  // Over what has arrived.
  struct Totals {
    size_t assets = 0, fetched = 0;
    uint64_t fetched_bytes = 0;
  };
  Totals totals() const;

  // How far those are that were asked for.
  struct Progress {
    size_t assets = 0, ready = 0;
    uint64_t bytes = 0,
             arrived_bytes = 0;  // of all of them; of one in the cache all have arrived once it is read
    // The first, in the order they were asked for, that is not ready: an object that has it. Empty when all
    // are.
    std::string object;
    uint64_t object_bytes = 0, object_arrived_bytes = 0;
  };
  Progress progress() const;

 private:
  struct Loaded {
    Asset asset;
    uint64_t fetched_bytes = 0;
  };
  // Guarded by the mutex; shared with the thread that fetches it.
  struct RequestedAsset {
    std::string object;  // that has it
    uint64_t bytes = 0, arrived_bytes = 0;
    std::optional<Result<Loaded>> loaded;
    std::shared_ptr<const AssetPart> part;
    size_t step = 0;  // as Arrived has it
  };
  void request(const std::string& hash, uint64_t bytes, const std::string& object);
  Result<Loaded> load(const std::string& hash, uint64_t bytes, RequestedAsset& asked);
  void keep_part(const ProgressiveDecoder& so_far, RequestedAsset& asked);

  const FetchAsset fetch_;
  const AssetCache& cache_;
  const std::stop_token stop_;
  bool shows_parts_ = false;
  mutable std::mutex mutex_;  // guards all below
  std::condition_variable arrived_;
  Totals totals_;
  std::map<std::string, std::shared_ptr<RequestedAsset>> assets_;
  std::vector<std::shared_ptr<const RequestedAsset>> in_order_;  // they were asked for in
  std::vector<std::future<void>> threads_;                       // last: they use all of the above
};

}  // namespace livegs
