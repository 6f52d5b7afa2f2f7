// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/result.h"

namespace livegs {

// The transfer form of an asset or an edit with zstd frames that store their bytes, for readers without a
// zstd decoder (browsers): HTTP compresses it instead. Any reader of proto/asset_format.md reads it.
// InvalidData for bytes that are not a complete asset.
Result<std::vector<std::byte>> store_blocks(std::span<const std::byte> progressive);

}  // namespace livegs
