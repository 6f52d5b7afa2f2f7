// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "core/result.h"
#include "gaussian/asset/decoded_asset.h"
#include "gaussian/read_options.h"

namespace livegs {

// Recognises and converts activated values, as ReadOptions specifies. `asset` has the values of the file.
Result<void> convert_activated(AssetFile& file, const ReadOptions& options, std::string_view name);

}  // namespace livegs
