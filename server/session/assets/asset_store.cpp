// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/assets/asset_store.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>

#include "core/content_hash.h"
#include "gaussian/asset_file.h"
#include "gaussian/progressive_asset.h"

namespace livegs {
namespace {

void measure(const GaussianAsset& asset, AssetBytes& encoded) {
  Eigen::AlignedBox3f box;
  float log_deviation = -std::numeric_limits<float>::infinity();
  for (const Eigen::Vector3f& position : asset.positions) box.extend(position);
  for (const Eigen::Vector3f& log_scale : asset.log_scales)
    log_deviation = std::max(log_deviation, log_scale.maxCoeff());
  if (!box.isEmpty()) encoded.diagonal = static_cast<double>(box.diagonal().norm());
  encoded.deviation = std::exp(static_cast<double>(log_deviation));
}

}  // namespace

AssetBytes encode_asset(const GaussianAsset& asset) {
  AssetBytes encoded;
  encoded.hash = content_hash(encode_ply(asset));
  encoded.bytes = encode_progressive(asset);
  measure(asset, encoded);
  return encoded;
}

std::shared_ptr<const AssetBytes> AssetStore::add(const std::shared_ptr<const GaussianAsset>& asset) {
  std::unique_lock lock(mutex_);
  encoded_.wait(lock, [&] { return !encoding_.contains(asset.get()); });
  if (const auto found = by_asset_.find(asset); found != by_asset_.end()) return found->second;
  encoding_.insert(asset.get());
  lock.unlock();
  std::shared_ptr<const AssetBytes> encoded;
  std::exception_ptr failed;  // out of memory; a waiting caller retries the encoding
  try {
    encoded = std::make_shared<const AssetBytes>(encoder_(*asset));
  } catch (...) {
    failed = std::current_exception();
  }
  lock.lock();
  encoding_.erase(asset.get());
  encoded_.notify_all();
  if (failed) std::rethrow_exception(failed);
  Kept& kept =
      // equal content is stored once
      by_hash_.try_emplace(encoded->hash, encoded, std::nullopt).first->second;
  kept.unused_since_ns.reset();
  by_asset_.emplace(asset, kept.bytes);
  return kept.bytes;
}

bool AssetStore::has(const std::shared_ptr<const GaussianAsset>& asset) const {
  std::lock_guard lock(mutex_);
  return by_asset_.contains(asset);
}

std::shared_ptr<const AssetBytes> AssetStore::find(std::string_view hash) const {
  std::lock_guard lock(mutex_);
  const auto found = by_hash_.find(hash);
  return found == by_hash_.end() ? nullptr : found->second.bytes;
}

void AssetStore::drop_unused(const std::set<std::string>& announced, int64_t now_ns) {
  std::lock_guard lock(mutex_);
  // Assets of a replaced scene have no other owner any more.
  std::erase_if(by_asset_, [](const auto& known) { return known.first.use_count() == 1; });
  std::set<std::string_view> used;
  for (const auto& [asset, bytes] : by_asset_) used.insert(bytes->hash);
  for (auto& [hash, kept] : by_hash_) {
    const bool needed = used.contains(hash) || announced.contains(hash);
    if (needed) kept.unused_since_ns.reset();
    if (!needed && !kept.unused_since_ns) kept.unused_since_ns = now_ns;
  }
  std::erase_if(by_hash_, [&](const auto& one) {
    const auto& since_ns = one.second.unused_since_ns;
    return since_ns && now_ns - *since_ns >= kUnusedAssetLifetime_ns;
  });
}

std::vector<std::string> AssetStore::hashes() const {
  std::lock_guard lock(mutex_);
  std::vector<std::string> all;
  for (const auto& [hash, kept] : by_hash_) all.push_back(hash);
  return all;
}

}  // namespace livegs
