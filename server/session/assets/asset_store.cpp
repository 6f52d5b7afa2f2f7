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

std::shared_ptr<const AssetBytes> AssetStore::add(const Asset& asset, const Asset& base) {
  const std::shared_ptr<const AssetBytes> from = base && base != asset ? add(base) : nullptr;
  const auto has_edit = [&](const AssetBytes& bytes) {
    return !from || from->hash == bytes.hash || by_hash_.at(bytes.hash).edits.contains(from->hash);
  };
  std::unique_lock lock(mutex_);
  encoded_.wait(lock, [&] { return !encoding_.contains(asset.get()); });
  auto found = by_asset_.find(asset);
  if (found != by_asset_.end() && has_edit(*found->second)) return found->second;
  std::shared_ptr<const AssetBytes> encoded = found != by_asset_.end() ? found->second : nullptr;
  encoding_.insert(asset.get());
  lock.unlock();
  std::optional<std::vector<std::byte>> edit;
  std::exception_ptr failed;  // out of memory; a waiting caller retries the encoding
  try {
    if (from) edit = encode_edit(*base, *asset);
    if (!encoded) encoded = std::make_shared<const AssetBytes>(encoder_(*asset));
    if (edit &&
        static_cast<double>(edit->size()) > kMaxEditShare * static_cast<double>(encoded->bytes.size()))
      edit.reset();
  } catch (...) {
    failed = std::current_exception();
  }
  lock.lock();
  encoding_.erase(asset.get());
  encoded_.notify_all();
  if (failed) std::rethrow_exception(failed);
  Kept& kept =
      // equal content is stored once
      by_hash_.try_emplace(encoded->hash, Kept{encoded, std::nullopt, {}}).first->second;
  kept.unused_since_ns.reset();
  if (from && from->hash != encoded->hash)
    kept.edits[from->hash] =
        edit ? std::make_shared<const std::vector<std::byte>>(*std::move(edit)) : nullptr;
  by_asset_.emplace(asset, kept.bytes);
  return kept.bytes;
}

void AssetStore::note_described(const std::string& name, const Asset& asset) {
  std::lock_guard lock(mutex_);
  described_[name] = asset;
}

AssetStore::Asset AssetStore::described(const std::string& name) const {
  std::lock_guard lock(mutex_);
  const auto found = described_.find(name);
  return found == described_.end() ? nullptr : found->second.lock();
}

AssetStore::Bytes AssetStore::find_bytes(std::string_view hash, std::string_view base_hash) const {
  std::lock_guard lock(mutex_);
  const auto kept = by_hash_.find(hash);
  if (kept == by_hash_.end()) return nullptr;
  if (base_hash.empty()) return Bytes(kept->second.bytes, &kept->second.bytes->bytes);
  const auto edit = kept->second.edits.find(base_hash);
  return edit == kept->second.edits.end() ? nullptr : edit->second;
}

bool AssetStore::has(const Asset& asset) const {
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
  std::erase_if(described_, [](const auto& known) { return known.second.expired(); });
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
