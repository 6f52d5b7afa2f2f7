// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

#include "core/result.h"
#include "gaussian/asset/bytes.h"
#include "gaussian/asset/decoded_asset.h"
#include "gaussian/read_options.h"

// The readers, one per format, internal to this room. Each returns the values of the file in the frame of
// GaussianAsset. The caller then calls establish_invariants.

namespace livegs {

struct PlyHeader;
class SogFiles;

Result<AssetFile> read_gaussian_ply(const PlyHeader& header, Bytes bytes, std::string_view name,
                                    const ReadOptions& options);
Result<AssetFile> read_compressed_ply(const PlyHeader& header, Bytes bytes, std::string_view name);
bool is_compressed_ply(const PlyHeader& header);

Result<AssetFile> read_spz(Bytes bytes, std::string_view name);
Result<AssetFile> read_splat(Bytes bytes, std::string_view name);

Result<AssetFile> read_sog_bundle(Bytes bytes, std::string_view name);
// `index`: meta.json or lod-meta.json.
Result<AssetFile> read_sog_folder(const std::filesystem::path& index, std::string_view name);
// `total_bytes`, the size of all files, limits the accepted kernel count.
Result<AssetFile> read_sog(const SogFiles& files, uint64_t total_bytes, std::string_view name);

// The finest level of a streamed SOG, from its lod-meta.json.
Result<AssetFile> read_streamed_sog(const std::filesystem::path& index, std::string_view name);

// glTF or GLB. `folder`: of files that the document refers to; empty if there is none.
Result<AssetFile> read_gltf(Bytes bytes, const std::filesystem::path& folder, std::string_view name);

}  // namespace livegs
