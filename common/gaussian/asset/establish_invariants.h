// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "core/result.h"
#include "gaussian/asset/decoded_asset.h"

namespace livegs {

// Turns values as they stood in a file into a GaussianAsset that keeps its invariants: the last step of every
// reader. asset_file.h states the policy. Values that keep them already are left alone to the bit.
Result<void> establish_invariants(AssetFile& file, std::string_view name);

// Whether a kernel is as it would leave it.
bool meets_invariants(const GaussianAsset& asset, size_t kernel);

}  // namespace livegs
