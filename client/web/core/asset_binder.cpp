// SPDX-License-Identifier: Apache-2.0
#include "web/core/asset_binder.h"

#include <algorithm>
#include <utility>

#include "skin/skin_kernels.h"
#include "splat/passes/kernel_looks.h"
#include "viewer/assets/rest_of_part.h"
#include "wire/rest_body_codec.h"

namespace livegs {

Result<void> AssetBinder::take_asset(uint32_t asset, std::span<const std::byte> bytes) {
  Asset& one = assets_[asset];
  if (one.whole) return {};
  if (auto taken = one.decoder.take(bytes); !taken) return taken;
  one.kernel_count = static_cast<uint32_t>(one.decoder.kernel_count());
  return {};
}

bool AssetBinder::edit_asset(uint32_t asset, uint32_t base) {
  const auto found = assets_.find(base);
  if (found == assets_.end() || !found->second.whole) return false;
  const std::shared_ptr<const AssetPart>& whole = found->second.whole;
  if (whole->asset.size() != found->second.kernel_count) return false;
  assets_[asset] = {ProgressiveDecoder({whole, &whole->asset}), 0, nullptr};
  return true;
}

bool AssetBinder::finish_asset(uint32_t asset) {
  const auto found = assets_.find(asset);
  if (found == assets_.end()) return false;
  Asset& one = found->second;
  if (!one.whole && one.decoder.complete()) {
    one.whole = std::make_shared<const AssetPart>(one.decoder.part());
    one.decoder = {};
  }
  return one.whole != nullptr;
}

Result<void> AssetBinder::describe(uint32_t description, uint32_t asset,
                                   std::span<const std::byte> rest_body) {
  auto rest = decode_rest_body(rest_body);
  if (!rest) return rest.error();
  if (rest->kind == DriverKind::Particles)
    return unsupported("particles cannot be drawn in a browser; use livegs-client");
  descriptions_[description] = {asset, *std::move(rest)};
  return {};
}

Result<void> AssetBinder::bind(const Description& description, const Asset& asset) {
  const auto part = asset.whole ? asset.whole : std::make_shared<const AssetPart>(asset.decoder.part());
  const GaussianAsset& kernels = part->asset;
  auto bindings = bind_kernels(kernels, rest_of_part(description.rest, part->indices));
  if (!bindings) return bindings.error();
  const size_t words = sh_row_words(kernels);
  bound_.sh_degree = kernels.sh_degree;
  bound_.antialiased = kernels.antialiased;
  bound_.reserved = std::max(asset.kernel_count, static_cast<uint32_t>(kernels.size()));
  bound_.rest.resize(kernels.size());
  pack_rest_rows(*bindings, {}, 0, bound_.rest);
  bound_.bands.resize(kernels.size() * words);
  bound_.looks.reserve(kernels.size());
  for (size_t k = 0; k < kernels.size(); ++k) {
    bound_.looks.push_back(look_row(kernels, k));
    pack_bands(kernels, k, std::span(bound_.bands).subspan(k * words, words));
  }
  bound_.node_terms = std::move(bindings->node_terms);
  bound_.node_terms_begin = std::move(bindings->node_terms_begin);
  return {};
}

Result<bool> AssetBinder::bind_next() {
  bound_ = {};
  for (auto at = descriptions_.begin(); at != descriptions_.end(); ++at) {
    auto& [number, description] = *at;
    const auto asset = assets_.find(description.asset);
    const size_t arrived = asset == assets_.end() ? 0 : asset->second.arrived();
    const bool whole = arrived == SIZE_MAX;
    // Parts double in size, since each part costs as much as it holds.
    if (arrived == 0 || arrived == description.bound || (!whole && arrived / 2 < description.bound)) continue;
    bound_.description = number;
    auto done = bind(description, asset->second);
    description.bound = arrived;
    if (!done) {
      bound_ = {};
      bound_.description = number;
    }
    if (whole || !done) descriptions_.erase(at);
    if (!done) return done.error();
    return true;
  }
  return false;
}

}  // namespace livegs
