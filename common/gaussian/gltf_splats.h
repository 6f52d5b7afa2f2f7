// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "core/result.h"
#include "gaussian/asset_frame.h"
#include "gaussian/gaussian_asset.h"
#include "gaussian/gltf_buffer.h"

// Parts of glTF 2.0 documents with splats: KHR_gaussian_splatting (ratified form). Any thread.

namespace livegs {

// The primitive of an asset, turned to y up: half a turn about x. Adds the extensions to `used`. `spz`: the
// attributes are compressed (KHR_gaussian_splatting_compression_spz_2); fails if the asset does not fit.
// Precondition: the asset has kernels.
Result<nlohmann::json> gltf_splat_primitive(const GaussianAsset& asset, bool spz, GltfBuffer& buffer,
                                            std::set<std::string>& used);

// A .glb of a document whose buffer 0, if any, is `binary`. Fails above 4 GiB.
Result<std::vector<std::byte>> join_glb(std::string_view json, std::span<const std::byte> binary);

}  // namespace livegs
