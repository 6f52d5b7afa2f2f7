// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <condition_variable>
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

// The bytes of an asset as clients fetch them (proto/asset_format.md), and the hash it is named by: that of
// its lossless .ply, so that a name does not hang on how it is compressed.
struct AssetBytes {
  std::string hash;
  std::vector<std::byte> bytes;
  // In the asset's units: the diagonal of the box around its kernels, and the largest standard deviation of
  // one.
  double diagonal = 0, deviation = 0;
};

AssetBytes encode_asset(const GaussianAsset& asset);

// So long bytes are kept after the last object that is drawn with them went: a client that joined before may
// come to them so late (kJoinTimeout_ns), and one that is behind hears of the change later.
inline constexpr int64_t kUnusedAssetLifetime_ns = 120'000'000'000;

// Every asset of the scene, encoded and hashed once, whoever asks and however many objects share it. Any
// thread.
class AssetStore {
 public:
  using Encoder =
      std::function<AssetBytes(const GaussianAsset&)>;  // any thread; in tests one that takes its time
  explicit AssetStore(Encoder encoder = encode_asset) : encoder_(std::move(encoder)) {}

  // Encodes on the calling thread the first time, and on no other, so that a tick beside it is not held up:
  // see asset_bench. Who asks for it meanwhile waits for that.
  std::shared_ptr<const AssetBytes> add(const std::shared_ptr<const GaussianAsset>& asset);
  bool has(const std::shared_ptr<const GaussianAsset>& asset) const;
  std::shared_ptr<const AssetBytes> find(std::string_view hash) const;  // nullptr if unknown
  // Drops what nobody needs any more: neither an object that somebody holds is drawn with it, nor was a
  // client told of it
  // (`told`) within the last kUnusedAssetLifetime_ns. Who is just sending it holds it.
  void drop_unused(const std::set<std::string>& told, int64_t now_ns);
  std::vector<std::string> hashes() const;  // of all there is

 private:
  const Encoder encoder_;
  mutable std::mutex mutex_;  // guards everything below
  std::condition_variable encoded_;
  std::set<const GaussianAsset*> encoding_;  // on some thread, right now
  std::map<std::shared_ptr<const GaussianAsset>, std::shared_ptr<const AssetBytes>> by_asset_;
  struct Kept {
    std::shared_ptr<const AssetBytes> bytes;
    std::optional<int64_t> unused_since_ns;
  };
  std::map<std::string, Kept, std::less<>> by_hash_;
};

}  // namespace livegs
