// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "gaussian/gaussian_asset.h"

namespace livegs {

// An asset as clients fetch it (proto/asset_format.md). `hash` identifies it: the hash of its lossless .ply,
// so that it does not depend on the compression.
struct AssetBytes {
  std::string hash;
  std::vector<std::byte> bytes;
  // In the asset's units: the diagonal of the bounding box of its kernels, and the largest standard deviation
  // of a kernel.
  double diagonal = 0, deviation = 0;
};

AssetBytes encode_asset(const GaussianAsset& asset);

// Time for which bytes are kept after the last object that uses them is removed. A client that joined earlier
// may fetch them this late (kJoinTimeout_ns), and a client that lags receives the removal later.
inline constexpr int64_t kUnusedAssetLifetime_ns = 120'000'000'000;

// Largest size of an edit over that of its asset. Larger: more fetches are edits, which save less and need
// the base in the memory of the client.
inline constexpr double kMaxEditShare = 0.75;

// Encodes and hashes every asset of the scene once, however many objects and clients use it. Any thread.
class AssetStore {
 public:
  using Encoder = std::function<AssetBytes(const GaussianAsset&)>;  // called on any thread
  explicit AssetStore(Encoder encoder = encode_asset) : encoder_(std::move(encoder)) {}

  using Asset = std::shared_ptr<const GaussianAsset>;
  // Encodes at the first call, on the calling thread and without worker threads, so that a concurrent tick is
  // not delayed (asset_bench). Concurrent calls for the same asset wait for the result.
  // `base`: an asset that clients may have. The asset is also encoded as an edit of it, up to kMaxEditShare.
  std::shared_ptr<const AssetBytes> add(const Asset& asset, const Asset& base = nullptr);
  // Notes that clients were sent the description of an object with this name and asset.
  void note_described(const std::string& name, const Asset& asset);
  Asset described(const std::string& name) const;  // the last one noted, null if it is gone
  bool has(const Asset& asset) const;
  std::shared_ptr<const AssetBytes> find(std::string_view hash) const;  // nullptr if unknown
  using Bytes = std::shared_ptr<const std::vector<std::byte>>;
  // The bytes of an asset, or of its edit if a base is given. Null if there are none.
  Bytes find_bytes(std::string_view hash, std::string_view base_hash) const;
  // Discards assets that no object uses and that are not in `announced`, the hashes known to clients, for
  // kUnusedAssetLifetime_ns. A transfer in progress holds its own reference.
  void drop_unused(const std::set<std::string>& announced, int64_t now_ns);
  std::vector<std::string> hashes() const;  // of all stored assets
  // Bytes of assets that were sent to clients so far, for metrics.
  void count_sent(size_t bytes) const { sent_bytes_ += bytes; }
  uint64_t sent_bytes() const { return sent_bytes_; }

 private:
  const Encoder encoder_;
  mutable std::atomic<uint64_t> sent_bytes_ = 0;
  mutable std::mutex mutex_;  // guards everything below
  std::condition_variable encoded_;
  std::set<const GaussianAsset*> encoding_;  // being encoded on some thread
  std::map<Asset, std::shared_ptr<const AssetBytes>> by_asset_;
  std::map<std::string, std::weak_ptr<const GaussianAsset>> described_;  // by name of the object
  struct Kept {
    std::shared_ptr<const AssetBytes> bytes;
    std::optional<int64_t> unused_since_ns;
    std::map<std::string, Bytes, std::less<>> edits;  // by hash of the base; null: too large
  };
  std::map<std::string, Kept, std::less<>> by_hash_;
};

}  // namespace livegs
