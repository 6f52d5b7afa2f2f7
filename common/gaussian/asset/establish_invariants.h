// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "core/result.h"
#include "gaussian/asset/decoded_asset.h"

namespace livegs {

// Turns the values of a file into a GaussianAsset that meets its invariants. This is the last step of every
// reader; asset_file.h states the policy. Valid values keep their bits.
Result<void> establish_invariants(AssetFile& file, std::string_view name);

// Whether a kernel already meets the invariants.
bool meets_invariants(const GaussianAsset& asset, size_t kernel);

}  // namespace livegs
