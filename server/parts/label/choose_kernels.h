// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>

#include "gaussian/gaussian_asset.h"

namespace livegs {

// Appends kernel k of `from`; both have the same degree of spherical harmonics.
void append_kernel(GaussianAsset& to, const GaussianAsset& from, size_t k);

// Some kernels, in the order of their indices in `kernels`.
GaussianAsset select_kernels(const GaussianAsset& asset, std::span<const uint32_t> kernels);

}  // namespace livegs
