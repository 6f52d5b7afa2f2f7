// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"

namespace livegs {

// Takes a piece of an asset, in order.
using TakeChunk =
    std::function<Result<void>(uint64_t offset, uint64_t total_bytes, std::span<const std::byte>)>;

// A folder of assets named by the SHA-256 of their bytes. What is in it never changes, so any number of
// clients may share it; what was cut off stays as HASH.part and is taken up again. Any thread.
class AssetCache {
 public:
  explicit AssetCache(std::filesystem::path folder) : folder_(std::move(folder)) {}

  struct Obtained {
    std::vector<std::byte> bytes;
    uint64_t fetched_bytes = 0;  // 0: it was here
  };
  // The asset of this name: from the folder if it is there and its bytes still have that hash, else by
  // `fetch`, from the given offset on. Fails when the bytes that came, from zero at the second attempt, are
  // not those asked for.
  using Fetch = std::function<Result<void>(uint64_t offset, const TakeChunk& take)>;
  Result<Obtained> obtain(const std::string& hash, uint64_t asset_bytes, const Fetch& fetch) const;

  const std::filesystem::path& folder() const { return folder_; }

  // $XDG_CACHE_HOME/livegs, else $HOME/.cache/livegs. NotFound when neither is set.
  static Result<std::filesystem::path> default_folder();

 private:
  std::filesystem::path folder_;
};

}  // namespace livegs
