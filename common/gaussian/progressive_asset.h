// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/result.h"
#include "gaussian/gaussian_asset.h"

// The transfer form of an asset: lossless, compressed and ordered so that each prefix can be drawn, coarse
// first. Specification: proto/asset_format.md. All functions may be called from any thread; an encoder or
// decoder is used by one thread at a time.

namespace livegs {

// Encodes an asset. Kernels are in descending order of contribution (opacity times covered area); ties keep
// the order of the asset. Precondition: at least one kernel.
std::vector<std::byte> encode_progressive(const GaussianAsset& asset);

// Encodes an asset as an edit of `base`: the runs of kernels that both have in the same order, and the other
// kernels of the asset ("Edits"). Kernels are the same if their values have the same bits. Empty if the
// harmonics differ in degree, the antialiasing differs, or no kernel is the same.
std::optional<std::vector<std::byte>> encode_edit(const GaussianAsset& base, const GaussianAsset& asset);

// A subset of the kernels of an asset, in its order.
struct AssetPart {
  GaussianAsset asset;            // degree 0 until higher harmonics arrive; missing ones are 0
  std::vector<uint32_t> indices;  // index of each kernel in the whole asset, ascending
};

// Decodes the bytes as they arrive. Any input is accepted: invalid bytes give an error, which every later
// call returns too. Memory is at most about 1024 times the received bytes, plus twice that of the base.
class ProgressiveDecoder {
 public:
  ProgressiveDecoder() = default;  // of a whole asset
  // Of a whole asset, or of an edit of `base`; null: of a whole asset only.
  explicit ProgressiveDecoder(std::shared_ptr<const GaussianAsset> base) : base_(std::move(base)) {}

  // Consumes the next bytes, of any length.
  Result<void> take(std::span<const std::byte> bytes);

  size_t kernel_count() const { return count_; }      // of the whole asset; 0 until the head has arrived
  size_t arrived() const { return indices_.size(); }  // kernels that can be drawn
  size_t arrived_harmonics() const { return with_harmonics_; }  // of those, kernels with all harmonics
  size_t blocks() const { return blocks_; }                     // decoded
  bool complete() const;

  // The kernels received so far. Kernels that violate the invariants of GaussianAsset are left out.
  AssetPart part() const;
  // The whole asset, bit-identical and in its order. Empty unless it is complete and has each kernel once.
  // Its invariants are not checked.
  std::optional<GaussianAsset> whole() const;

 private:
  Result<void> take_head(std::span<const std::byte> head);
  Result<void> take_block(std::span<const std::byte> payload, uint32_t count);
  bool take_runs(std::span<const std::byte> raw, size_t runs);
  bool take_kernels(std::span<const std::byte> raw, size_t count);
  bool take_harmonics(std::span<const std::byte> raw, size_t count);
  GaussianAsset gathered(std::span<const uint32_t> order, int degree) const;

  std::shared_ptr<const GaussianAsset> base_;
  // Of an edit: kernels of the base in the asset, and the ends of the last run in the base and the asset.
  size_t kept_ = 0;
  int64_t base_end_ = 0, asset_end_ = 0;
  std::vector<std::byte> waiting_;  // received bytes of the incomplete block
  std::optional<Error> failed_;
  bool has_head_ = false;
  int degree_ = 0;
  size_t count_ = 0, blocks_ = 0, with_harmonics_ = 0;
  std::vector<uint32_t> block_counts_;  // kernels of each block
  size_t harmonic_blocks_ = 0;
  // In order of arrival. Harmonics are stored separately, as far as received.
  GaussianAsset asset_;
  std::vector<Eigen::Vector3f> harmonics_;
  std::vector<uint32_t> indices_;
};

// Decodes a complete asset.
Result<GaussianAsset> decode_progressive(std::span<const std::byte> bytes);

}  // namespace livegs
