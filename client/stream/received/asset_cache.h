// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "core/result.h"
#include "gaussian/progressive_asset.h"

namespace livegs {

// Consumes a piece of an asset, in order.
using TakeChunk =
    std::function<Result<void>(uint64_t offset, uint64_t total_bytes, std::span<const std::byte>)>;

// A folder of assets, each a .ply named by the SHA-256 of its bytes. Files never change, so any number of
// clients may share the folder. Assets are transferred compressed, coarse levels first
// (proto/asset_format.md). An incomplete transfer is kept as HASH.part and resumed. Any thread.
class AssetCache {
 public:
  explicit AssetCache(std::filesystem::path folder) : folder_(std::move(folder)) {}

  struct Obtained {
    std::vector<std::byte> bytes;  // of the .ply
    uint64_t fetched_bytes = 0;    // 0: it was in the cache
  };
  // Returns the asset with this hash: from the folder if the file is present and intact, else through
  // `fetch`, from the given offset on, `asset_bytes` in all. Fails if the bytes do not match the hash after a
  // second attempt from offset 0. `progress` is called on this thread when more kernels can be drawn. Waits
  // while another client fetches the asset; returns Unavailable once `stop` is requested.
  using Fetch = std::function<Result<void>(uint64_t offset, const TakeChunk& take)>;
  // Fetches the asset as an edit of an asset that the client has, from offset 0. Called if the asset is not
  // in the folder. `base` may wait for the base, and returns null if it is missing.
  struct Edit {
    std::function<std::shared_ptr<const GaussianAsset>()> base;
    Fetch fetch;
  };
  using Progress = std::function<void(const ProgressiveDecoder& so_far)>;
  Result<Obtained> obtain(const std::string& hash, uint64_t asset_bytes, const Fetch& fetch,
                          const Progress& progress = {}, std::stop_token stop = {}) const {
    return obtain(hash, asset_bytes, std::span(&fetch, 1), progress, std::move(stop));
  }
  // From the edit if there is one and it gives the right bytes. Else from the first of several sources that
  // does; the last one is the server. The failure of an earlier one is logged, and the next one continues the
  // transfer. Precondition: there is a source.
  Result<Obtained> obtain(const std::string& hash, uint64_t asset_bytes, std::span<const Fetch> sources,
                          const Progress& progress = {}, std::stop_token stop = {},
                          const Edit& edit = {}) const;

  const std::filesystem::path& folder() const { return folder_; }

  // $XDG_CACHE_HOME/livegs, else $HOME/.cache/livegs. NotFound when neither is set.
  static Result<std::filesystem::path> default_folder();

 private:
  std::filesystem::path folder_;
};

}  // namespace livegs
