// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

// Names of splat files. All functions may be called from any thread.

namespace livegs {

inline constexpr const char* kAssetEndings = ".ply, .compressed.ply, .spz, .sog, .splat, .glb or .gltf";

// The ending of a splat file in any letter case, returned in lower case: ".compressed.ply" for that format,
// ".ply" for other .ply files. nullopt: not the name of a splat file.
std::optional<std::string_view> asset_ending(std::string_view name);

// Whether `path` names the index of an unpacked asset, which stands for its folder: the meta.json of an
// unbundled .sog, or the lod-meta.json of a streamed one.
bool is_asset_index(const std::filesystem::path& path);

// The index in `folder`, if the folder is such an asset.
std::optional<std::filesystem::path> asset_index(const std::filesystem::path& folder);

// Path of an asset without its ending; of an index, its folder. Other paths are returned unchanged.
std::filesystem::path asset_stem(const std::filesystem::path& path);

}  // namespace livegs
