// SPDX-License-Identifier: Apache-2.0
#include "common/gaussian/gltf/gltf_sample.h"

#include <cmath>

#include "gaussian/asset/y_up.h"
#include "gaussian/opacity.h"

namespace livegs {

size_t GltfSample::add_view(Bytes bytes) {
  json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", bytes.size()}});
  binary.insert(binary.end(), bytes.begin(), bytes.end());
  while (binary.size() % 4) binary.push_back(std::byte{0});
  json["buffers"][0]["byteLength"] = binary.size();
  return json["bufferViews"].size() - 1;
}

size_t GltfSample::add(const std::vector<float>& values, size_t components) {
  static constexpr const char* kTypes[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
  json["accessors"].push_back({{"bufferView", add_view(std::as_bytes(std::span(values)))},
                               {"componentType", 5126},
                               {"count", values.size() / components},
                               {"type", kTypes[components - 1]}});
  return json["accessors"].size() - 1;
}

std::vector<std::byte> GltfSample::glb() const {
  std::string text = json.dump();
  while (text.size() % 4) text += ' ';
  std::vector<std::byte> bytes;
  append(bytes, uint32_t{0x46546c67});
  append(bytes, uint32_t{2});
  append(bytes, static_cast<uint32_t>(28 + text.size() + binary.size()));
  append(bytes, static_cast<uint32_t>(text.size()));
  append(bytes, uint32_t{0x4e4f534a});
  for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
  append(bytes, static_cast<uint32_t>(binary.size()));
  append(bytes, uint32_t{0x004e4942});
  bytes.insert(bytes.end(), binary.begin(), binary.end());
  return bytes;
}

std::vector<std::byte> GltfSample::gltf(const std::string& uri) const {
  nlohmann::json with = json;
  with["buffers"][0]["uri"] = uri;
  const std::string text = with.dump(1);
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

std::string GltfSample::data_uri() const {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string uri = "data:application/octet-stream;base64,";
  for (size_t i = 0; i < binary.size(); i += 3) {
    uint32_t bits = 0;
    for (size_t k = 0; k < 3; ++k) bits = bits << 8 | (i + k < binary.size() ? byte_at(binary, i + k) : 0);
    for (size_t k = 0; k < 4; ++k) uri += i + k > binary.size() ? '=' : kDigits[bits >> (18 - 6 * k) & 63];
  }
  return uri;
}

GltfSample gltf_sample(const GaussianAsset& asset) {
  GaussianAsset up = asset;
  turn_half_about_x(up);
  GltfSample sample;
  sample.json["asset"]["version"] = "2.0";
  sample.json["extensionsUsed"] = nlohmann::json::array({"KHR_gaussian_splatting"});
  sample.json["scene"] = 0;
  sample.json["scenes"][0]["nodes"] = nlohmann::json::array({0});
  sample.json["nodes"][0]["mesh"] = 0;
  std::vector<float> positions, rotations, scales, opacities;
  for (size_t i = 0; i < up.size(); ++i) {
    positions.insert(positions.end(), up.positions[i].begin(), up.positions[i].end());
    const auto& q = up.rotations[i].coeffs();
    rotations.insert(rotations.end(), {q[0], q[1], q[2], q[3]});
    for (const float scale : up.log_scales[i]) scales.push_back(std::exp(scale));
    opacities.push_back(opacity_of_logit(up.opacity_logits[i]));
  }
  nlohmann::json attributes;
  const std::string prefix = "KHR_gaussian_splatting:";
  attributes["POSITION"] = sample.add(positions, 3);
  attributes[prefix + "ROTATION"] = sample.add(rotations, 4);
  attributes[prefix + "SCALE"] = sample.add(scales, 3);
  attributes[prefix + "OPACITY"] = sample.add(opacities, 1);
  size_t k = 0;
  for (int degree = 0; degree <= up.sh_degree; ++degree) {
    for (int n = 0; n < 2 * degree + 1; ++n) {
      std::vector<float> values;
      for (size_t i = 0; i < up.size(); ++i) {
        const Eigen::Vector3f& value = degree == 0 ? up.sh_dc[i] : up.sh_rest[i * up.sh_rest_count() + k];
        values.insert(values.end(), value.begin(), value.end());
      }
      if (degree > 0) ++k;
      attributes[prefix + "SH_DEGREE_" + std::to_string(degree) + "_COEF_" + std::to_string(n)] =
          sample.add(values, 3);
    }
  }
  nlohmann::json primitive;
  primitive["mode"] = 0;
  primitive["attributes"] = attributes;
  primitive["extensions"]["KHR_gaussian_splatting"] = {{"kernel", "ellipse"},
                                                       {"colorSpace", "srgb_rec709_display"}};
  sample.json["meshes"][0]["primitives"].push_back(primitive);
  return sample;
}

}  // namespace livegs
