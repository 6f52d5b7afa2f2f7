// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "core/result.h"
#include "gaussian/progressive_asset.h"

namespace livegs {

// Takes a piece of an asset, in order.
using TakeChunk =
    std::function<Result<void>(uint64_t offset, uint64_t total_bytes, std::span<const std::byte>)>;

// A folder of assets, each a .ply named by the SHA-256 of its bytes. What is in it never changes, so any
// number of clients may share it. What comes is compressed and coarse first (proto/asset_format.md); as long
// as it is not whole, or when it was cut off, it stays as HASH.part and is taken up again. Any thread.
class AssetCache {
 public:
  explicit AssetCache(std::filesystem::path folder) : folder_(std::move(folder)) {}

  struct Obtained {
    std::vector<std::byte> bytes;  // of the .ply
    uint64_t fetched_bytes = 0;    // 0: it was here
  };
  // The asset of this name: from the folder if it is there and its bytes still have that hash, else by
  // `fetch`, from the given offset on, of `asset_bytes` in all. Fails when the bytes that came, from zero at
  // the second attempt, do not make the asset asked for. `progress` is called, on this thread, when more of
  // it can be drawn. Waits while another client fetches it, until `stop` is requested: then Unavailable.
  using Fetch = std::function<Result<void>(uint64_t offset, const TakeChunk& take)>;
  using Progress = std::function<void(const ProgressiveDecoder& so_far)>;
  Result<Obtained> obtain(const std::string& hash, uint64_t asset_bytes, const Fetch& fetch,
                          const Progress& progress = {}, std::stop_token stop = {}) const;

  const std::filesystem::path& folder() const { return folder_; }

  // $XDG_CACHE_HOME/livegs, else $HOME/.cache/livegs. NotFound when neither is set.
  static Result<std::filesystem::path> default_folder();

 private:
  std::filesystem::path folder_;
};

}  // namespace livegs
