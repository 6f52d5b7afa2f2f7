// SPDX-License-Identifier: Apache-2.0
// The layout is described in splat_reader.cpp.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "gaussian/asset/bytes.h"
#include "gaussian/asset_file.h"
#include "gaussian/opacity.h"

namespace livegs {
namespace {

uint8_t rounded_byte(float value) {
  return static_cast<uint8_t>(std::clamp(std::round(value), 0.0f, 255.0f));
}

}  // namespace

Result<std::vector<std::byte>> encode_splat(const GaussianAsset& asset) {
  if (asset.size() == 0) return invalid_argument("splat: an asset without kernels cannot be written");
  std::vector<float> importance(asset.size());  // logarithm of opacity times volume
  for (size_t i = 0; i < asset.size(); ++i)
    importance[i] = asset.log_scales[i].sum() + std::log(opacity_of_logit(asset.opacity_logits[i]));
  std::vector<uint32_t> order(asset.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](uint32_t a, uint32_t b) { return importance[a] > importance[b]; });
  std::vector<std::byte> bytes;
  bytes.reserve(32 * asset.size());
  for (const uint32_t i : order) {
    for (const float value : asset.positions[i]) append(bytes, value);
    for (const float value : asset.log_scales[i]) append(bytes, std::exp(value));
    for (const float dc : asset.sh_dc[i]) append(bytes, rounded_byte((0.5f + kShBand0 * dc) * 255));
    append(bytes, rounded_byte(opacity_of_logit(asset.opacity_logits[i]) * 255));
    const Eigen::Quaternionf& q = asset.rotations[i];
    // A component of 1 would be 256; negated, the largest component has all of its byte.
    const float sign = std::max({q.w(), q.x(), q.y(), q.z()}) > 0.99f ? -1.0f : 1.0f;
    for (const float value : {q.w(), q.x(), q.y(), q.z()})
      append(bytes, rounded_byte(sign * value * 128 + 128));
  }
  return bytes;
}

}  // namespace livegs
