// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "core/assert.h"
#include "gaussian/asset/bytes.h"
#include "gaussian/asset_file.h"

namespace livegs {
namespace {

std::string header_of(const GaussianAsset& asset) {
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  if (asset.antialiased) header += "comment SplatRenderMode: mip\n";
  header += "element vertex " + std::to_string(asset.size()) + "\n";
  const auto add = [&](const std::string& name) { header += "property float " + name + "\n"; };
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"}) add(name);
  for (size_t i = 0; i < 3 * asset.sh_rest_count(); ++i) add("f_rest_" + std::to_string(i));
  for (const char* name : {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
    add(name);
  return header + "end_header\n";
}

}  // namespace

std::vector<std::byte> encode_ply(const GaussianAsset& asset) {
  const size_t rest = asset.sh_rest_count();
  const size_t floats_per_row = 17 + 3 * rest;
  LIVEGS_ASSERT(asset.sh_rest.size() == asset.size() * rest);
  const std::string header = header_of(asset);
  std::vector<std::byte> bytes(header.size() + asset.size() * floats_per_row * sizeof(float));
  std::memcpy(bytes.data(), header.data(), header.size());

  std::vector<float> row(floats_per_row);
  std::byte* at = bytes.data() + header.size();
  for (size_t i = 0; i < asset.size(); ++i) {
    float* next = row.data();
    for (const float value : asset.positions[i]) *next++ = value;
    for (int n = 0; n < 3; ++n) *next++ = 0;
    for (const float value : asset.sh_dc[i]) *next++ = value;
    for (int channel = 0; channel < 3; ++channel) {
      for (size_t k = 0; k < rest; ++k) *next++ = asset.sh_rest[i * rest + k][channel];
    }
    *next++ = asset.opacity_logits[i];
    for (const float value : asset.log_scales[i]) *next++ = value;
    const Eigen::Quaternionf& q = asset.rotations[i];
    for (const float value : {q.w(), q.x(), q.y(), q.z()}) *next++ = value;
    std::memcpy(at, row.data(), floats_per_row * sizeof(float));
    at += floats_per_row * sizeof(float);
  }
  return bytes;
}

}  // namespace livegs
