// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gaussian/gaussian_asset.h"

namespace livegs {

// The bytes of an asset as clients fetch them (proto/asset_format.md), and the hash it is named by: that of its lossless .ply,
// so that a name does not hang on how it is compressed.
struct AssetBytes {
  std::string hash;
  std::vector<std::byte> bytes;
  // In the asset's units: the diagonal of the box around its kernels, and the largest standard deviation of one.
  double diagonal = 0, deviation = 0;
};

// Every asset of the scene, encoded and hashed once, whoever asks and however many objects share it. Any
// thread.
class AssetStore {
 public:
  // Encodes on the calling thread the first time, and on no other, so that a tick beside it is not held up: see
  // asset_bench.
  std::shared_ptr<const AssetBytes> add(const std::shared_ptr<const GaussianAsset>& asset);
  bool has(const std::shared_ptr<const GaussianAsset>& asset) const;
  std::shared_ptr<const AssetBytes> find(std::string_view hash) const;  // nullptr if unknown

 private:
  mutable std::mutex mutex_;  // guards both maps
  std::map<std::shared_ptr<const GaussianAsset>, std::shared_ptr<const AssetBytes>> by_asset_;
  std::map<std::string, std::shared_ptr<const AssetBytes>, std::less<>> by_hash_;
};

}  // namespace livegs
