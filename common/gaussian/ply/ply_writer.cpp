// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "core/assert.h"
#include "gaussian/asset/bytes.h"
#include "gaussian/asset_file.h"

namespace livegs {
namespace {

std::string header_of(const GaussianAsset& asset, const AssetFrame& frame, bool doubles) {
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  if (asset.antialiased) header += "comment SplatRenderMode: mip\n";
  for (const std::string& line : frame_lines(frame, false)) header += "comment " + line + "\n";
  header += "element vertex " + std::to_string(asset.size()) + "\n";
  const auto add = [&](const std::string& name) { header += "property float " + name + "\n"; };
  for (const char* name : {"x", "y", "z"})
    header += std::string("property ") + (doubles ? "double " : "float ") + name + "\n";
  for (const char* name : {"nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"}) add(name);
  for (size_t i = 0; i < 3 * asset.sh_rest_count(); ++i) add("f_rest_" + std::to_string(i));
  for (const char* name : {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
    add(name);
  return header + "end_header\n";
}

}  // namespace

std::vector<std::byte> encode_ply(const GaussianAsset& asset, const AssetFrame& frame, bool with_origin) {
  const size_t rest = asset.sh_rest_count();
  const size_t floats_per_row = 14 + 3 * rest;  // without the position
  const size_t row_bytes =
      3 * (with_origin ? sizeof(double) : sizeof(float)) + floats_per_row * sizeof(float);
  LIVEGS_ASSERT(asset.sh_rest.size() == asset.size() * rest);
  AssetFrame stated = frame;
  if (with_origin) stated.origin.setZero();
  const std::string header = header_of(asset, stated, with_origin);
  std::vector<std::byte> bytes(header.size() + asset.size() * row_bytes);
  std::memcpy(bytes.data(), header.data(), header.size());

  std::vector<float> row(floats_per_row);
  std::byte* at = bytes.data() + header.size();
  for (size_t i = 0; i < asset.size(); ++i) {
    float* next = row.data();
    if (with_origin) {
      const Eigen::Vector3d position = frame.origin + asset.positions[i].cast<double>();
      std::memcpy(at, position.data(), sizeof(position));
      at += sizeof(position);
    } else {
      std::memcpy(at, asset.positions[i].data(), sizeof(Eigen::Vector3f));
      at += sizeof(Eigen::Vector3f);
    }
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
