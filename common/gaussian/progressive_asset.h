// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/result.h"
#include "gaussian/gaussian_asset.h"

// An asset as it is sent: lossless, compressed, and in such an order that whatever has come of it can be
// drawn, coarse at first. proto/asset_format.md is its specification. All functions may be called from any
// thread; an encoder or decoder is one thread's at a time.

namespace livegs {

// About 0.2 s for 100k kernels without harmonics on one core, 0.7 s with 45. The order is that of the
// kernels' contribution, opacity times the area they cover; of equal ones the first comes first. At least one
// kernel.
std::vector<std::byte> encode_progressive(const GaussianAsset& asset);

// Some kernels of an asset, in its order.
struct AssetPart {
  GaussianAsset asset;  // of degree 0 while no higher harmonics have come; those that have not are 0
  std::vector<uint32_t> indices;  // of each kernel in the whole asset, ascending
};

// Takes the bytes as they come. Any bytes: those that are no such asset are an error, which every later call
// answers too. Memory is some 1024 times the bytes that came at most.
class ProgressiveDecoder {
 public:
  // The next bytes, any number of them.
  Result<void> take(std::span<const std::byte> bytes);

  size_t kernel_count() const { return count_; }      // of the whole asset; 0 before its head has come
  size_t arrived() const { return indices_.size(); }  // kernels that can be drawn
  size_t arrived_harmonics() const {
    return with_harmonics_;
  }                                          // of those, kernels with their higher harmonics
  size_t blocks() const { return blocks_; }  // decoded
  bool complete() const;

  // What can be drawn now. Kernels that break the invariants of GaussianAsset are left out.
  AssetPart part() const;
  // The asset, to the bit as it was encoded, in its order. Nothing unless it is complete and has each kernel
  // once. Its invariants are not looked at.
  std::optional<GaussianAsset> whole() const;

 private:
  Result<void> take_head(std::span<const std::byte> head);
  Result<void> take_block(std::span<const std::byte> payload, uint32_t count);
  bool take_kernels(std::span<const std::byte> raw, size_t count);
  bool take_harmonics(std::span<const std::byte> raw, size_t count);
  GaussianAsset gathered(std::span<const uint32_t> order, int degree) const;

  std::vector<std::byte> waiting_;  // the beginning of what is not whole yet
  std::optional<Error> failed_;
  bool has_head_ = false;
  int degree_ = 0;
  size_t count_ = 0, blocks_ = 0, with_harmonics_ = 0;
  std::vector<uint32_t> block_counts_;  // of the blocks of kernels
  size_t harmonic_blocks_ = 0;
  // In the order of arrival; the harmonics are apart, and as many as have come.
  GaussianAsset asset_;
  std::vector<Eigen::Vector3f> harmonics_;
  std::vector<uint32_t> indices_;
};

// All of it at once.
Result<GaussianAsset> decode_progressive(std::span<const std::byte> bytes);

}  // namespace livegs
