// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "gaussian/asset/bytes.h"
#include "gaussian/gaussian_asset.h"

namespace livegs {

// A glTF document with one splat primitive, for tests.
struct GltfSample {
  nlohmann::json json;
  std::vector<std::byte> binary;

  // Adds an accessor on its own buffer view; returns its number.
  size_t add(const std::vector<float>& values, size_t components);
  size_t add_view(Bytes bytes);

  std::vector<std::byte> glb() const;
  std::vector<std::byte> gltf(const std::string& uri) const;  // with this uri of the buffer
  std::string data_uri() const;
};

// The kernels of `asset`, turned to y up, as KHR_gaussian_splatting describes. Node 0 has them.
GltfSample gltf_sample(const GaussianAsset& asset);

}  // namespace livegs
