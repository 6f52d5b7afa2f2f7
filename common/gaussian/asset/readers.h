// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

#include "core/result.h"
#include "gaussian/asset/bytes.h"
#include "gaussian/asset/decoded_asset.h"

// One reader a format, inside this room. Each gives the values as they stand in the file, turned to the frame
// of GaussianAsset; establish_invariants is the caller's next step.

namespace livegs {

struct PlyHeader;
class SogFiles;

Result<AssetFile> read_gaussian_ply(const PlyHeader& header, Bytes bytes, std::string_view name);
Result<AssetFile> read_compressed_ply(const PlyHeader& header, Bytes bytes, std::string_view name);
bool is_compressed_ply(const PlyHeader& header);

Result<AssetFile> read_spz(Bytes bytes, std::string_view name);
Result<AssetFile> read_splat(Bytes bytes, std::string_view name);

Result<AssetFile> read_sog_bundle(Bytes bytes, std::string_view name);
Result<AssetFile> read_sog_folder(const std::filesystem::path& folder, std::string_view name);
// `total_bytes` of all files bounds how many kernels are believed.
Result<AssetFile> read_sog(const SogFiles& files, uint64_t total_bytes, std::string_view name);

}  // namespace livegs
