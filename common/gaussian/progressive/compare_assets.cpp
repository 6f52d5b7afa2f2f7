// SPDX-License-Identifier: Apache-2.0
#include "gaussian/progressive/compare_assets.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

namespace livegs {
namespace {

template <class Value>
bool same(const Value& a, const Value& b) {
  return std::memcmp(&a, &b, sizeof(Value)) == 0;
}

bool same_kernel(const GaussianAsset& a, size_t i, const GaussianAsset& b, size_t j) {
  const size_t rest = a.sh_rest_count();
  return same(a.positions[i], b.positions[j]) && same(a.log_scales[i], b.log_scales[j]) &&
         same(a.rotations[i], b.rotations[j]) && same(a.opacity_logits[i], b.opacity_logits[j]) &&
         same(a.sh_dc[i], b.sh_dc[j]) &&
         (rest == 0 ||
          std::memcmp(&a.sh_rest[i * rest], &b.sh_rest[j * rest], rest * sizeof(Eigen::Vector3f)) == 0);
}

// Equal for equal kernels; all values except the higher harmonics.
uint64_t key_of(const GaussianAsset& asset, size_t i) {
  uint64_t key = 0;
  const auto add = [&](float value) {
    key = (key ^ std::bit_cast<uint32_t>(value)) * 0x9E3779B97F4A7C15ull;  // 2^64 over the golden ratio
    key ^= key >> 32;
  };
  for (const auto* values : {&asset.positions, &asset.log_scales, &asset.sh_dc}) {
    for (int k = 0; k < 3; ++k) add((*values)[i][k]);
  }
  for (int k = 0; k < 4; ++k) add(asset.rotations[i].coeffs()[k]);
  add(asset.opacity_logits[i]);
  return key;
}

// The kernels of an asset by key; those of one key ascend.
class KernelIndex {
 public:
  explicit KernelIndex(const GaussianAsset& asset) : asset_(asset) {
    entries_.reserve(asset.size());
    for (uint32_t i = 0; i < asset.size(); ++i) entries_.emplace_back(key_of(asset, i), i);
    std::sort(entries_.begin(), entries_.end());
  }
  // The first kernel from `from` on that equals kernel i of `other` and is not in `used`.
  std::optional<uint32_t> find(const GaussianAsset& other, size_t i, uint32_t from,
                               const std::vector<bool>& used) const {
    const uint64_t key = key_of(other, i);
    for (auto at = std::lower_bound(entries_.begin(), entries_.end(), std::pair(key, from));
         at != entries_.end() && at->first == key; ++at) {
      if (!used[at->second] && same_kernel(asset_, at->second, other, i)) return at->second;
    }
    return std::nullopt;
  }

 private:
  const GaussianAsset& asset_;
  std::vector<std::pair<uint64_t, uint32_t>> entries_;
};

}  // namespace

AssetDifference compare_assets(const GaussianAsset& base, const GaussianAsset& asset) {
  AssetDifference difference;
  std::optional<KernelIndex> index;  // made when the assets differ for the first time
  std::vector<bool> used(base.size());
  uint32_t next = 0;  // kernel of the base after the last match
  for (uint32_t i = 0; i < asset.size(); ++i) {
    std::optional<uint32_t> match;
    if (next < base.size() && !used[next] && same_kernel(base, next, asset, i)) {
      match = next;
    } else {
      if (!index) index.emplace(base);
      match = index->find(asset, i, next, used);
      if (!match) match = index->find(asset, i, 0, used);
    }
    if (!match) {
      difference.added.push_back(i);
      continue;
    }
    auto& runs = difference.runs;
    if (!runs.empty() && runs.back().of_base + runs.back().length == *match &&
        runs.back().of_asset + runs.back().length == i)
      ++runs.back().length;
    else
      runs.push_back({*match, i, 1});
    used[*match] = true;
    next = *match + 1;
  }
  return difference;
}

}  // namespace livegs
