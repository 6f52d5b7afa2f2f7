// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "gaussian/gaussian_asset.h"
#include "splat/passes/project_splats_layout.h"

// The constant appearance of kernels, packed as the pass project_splats reads it: for DeviceKernels and for
// the browser client.

namespace livegs {

// Words per kernel of its bands above the first: half floats, two per word.
inline uint32_t sh_row_words(const GaussianAsset& asset) {
  return static_cast<uint32_t>((3 * asset.sh_rest_count() + 1) / 2);
}

KernelLookRow look_row(const GaussianAsset& asset, size_t kernel);

// Precondition: `words` are sh_row_words(asset) words of value 0.
void pack_bands(const GaussianAsset& asset, size_t kernel, std::span<uint32_t> words);

}  // namespace livegs
