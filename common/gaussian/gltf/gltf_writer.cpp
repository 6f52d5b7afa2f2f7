// SPDX-License-Identifier: Apache-2.0
// glTF 2.0, with KHR_gaussian_splatting in its ratified form.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "gaussian/asset/y_up.h"
#include "gaussian/asset_file.h"
#include "gaussian/gltf_splats.h"
#include "gaussian/spherical_harmonics.h"

namespace livegs {
namespace {

using Json = nlohmann::json;
using Eigen::Vector3f;
using Bounds = GltfBuffer::Bounds;
using Use = GltfBuffer::Use;

constexpr const char* kSplats = "KHR_gaussian_splatting";
constexpr const char* kSpz = "KHR_gaussian_splatting_compression_spz_2";

Json attributes_of(const GaussianAsset& asset, bool spz, GltfBuffer& buffer) {
  const size_t count = asset.size();
  const std::string prefix = std::string(kSplats) + ":";
  Json list;
  Vector3f low = asset.positions[0], high = low;
  for (const Vector3f& position : asset.positions) {
    low = low.cwiseMin(position);
    high = high.cwiseMax(position);
  }
  const auto add = [&](const std::string& name, size_t components, const auto& value_of) {
    const bool position = name == "POSITION";
    if (spz) {
      list[name] = buffer.add_empty(count, components, position ? &low : nullptr, position ? &high : nullptr);
      return;
    }
    std::vector<float> values(count * components);
    for (size_t i = 0; i < count; ++i) {
      const auto value = value_of(i);
      for (size_t k = 0; k < components; ++k)
        values[i * components + k] = value[static_cast<Eigen::Index>(k)];
    }
    list[name] =
        buffer.add_floats(values, components, position ? Bounds::Stated : Bounds::None, Use::Vertices);
  };
  using Scalar = Eigen::Matrix<float, 1, 1>;
  const auto opacity = [&](size_t i) { return 1.0f / (1.0f + std::exp(-asset.opacity_logits[i])); };
  add("POSITION", 3, [&](size_t i) { return asset.positions[i]; });
  add(prefix + "ROTATION", 4, [&](size_t i) { return asset.rotations[i].coeffs(); });
  add(prefix + "SCALE", 3, [&](size_t i) { return Vector3f(asset.log_scales[i].array().exp()); });
  add(prefix + "OPACITY", 1, [&](size_t i) { return Scalar(opacity(i)); });
  add(prefix + "SH_DEGREE_0_COEF_0", 3, [&](size_t i) { return asset.sh_dc[i]; });
  size_t k = 0;
  for (int degree = 1; degree <= asset.sh_degree; ++degree) {
    for (int n = 0; n < 2 * degree + 1; ++n, ++k) {
      add(prefix + "SH_DEGREE_" + std::to_string(degree) + "_COEF_" + std::to_string(n), 3,
          [&](size_t i) { return asset.sh_rest[i * asset.sh_rest_count() + k]; });
    }
  }
  if (spz) {
    list["COLOR_0"] = buffer.add_empty(count, 4, nullptr, nullptr);
    return list;
  }
  // For viewers without the extension, which draw coloured points.
  std::vector<uint8_t> colours(4 * count);
  const auto byte_of = [](float value) {
    return static_cast<uint8_t>(std::lround(255.0f * std::clamp(value, 0.0f, 1.0f)));
  };
  for (size_t i = 0; i < count; ++i) {
    for (int c = 0; c < 3; ++c)
      colours[4 * i + static_cast<size_t>(c)] = byte_of(0.5f + kShBand0 * asset.sh_dc[i][c]);
    colours[4 * i + 3] = byte_of(opacity(i));
  }
  list["COLOR_0"] = buffer.add_colours(colours);
  return list;
}

}  // namespace

Result<Json> gltf_splat_primitive(const GaussianAsset& asset, bool spz, GltfBuffer& buffer,
                                  std::set<std::string>& used) {
  Json primitive{{"mode", 0}};
  if (asset.antialiased) primitive["extras"]["livegs"].push_back("SplatRenderMode: mip");
  Json& extension = primitive["extensions"][kSplats];
  extension = {{"kernel", "ellipse"},
               {"colorSpace", "srgb_rec709_display"},
               {"projection", "perspective"},
               {"sortingMethod", "cameraDistance"}};
  used.insert(kSplats);
  if (spz) {
    const auto compressed = encode_spz(asset);
    if (!compressed) return compressed.error();
    extension["extensions"][kSpz]["bufferView"] = buffer.add_view(*compressed);
    used.insert(kSpz);
  }
  GaussianAsset y_up = asset;
  turn_half_about_x(y_up);
  primitive["attributes"] = attributes_of(y_up, spz, buffer);
  return primitive;
}

Result<std::vector<std::byte>> join_glb(std::string_view json, std::span<const std::byte> binary) {
  const auto padded = [](size_t size) { return (size + 3) / 4 * 4; };
  const size_t total = 12 + 8 + padded(json.size()) + (binary.empty() ? 0 : 8 + padded(binary.size()));
  if (total > UINT32_MAX)
    return Error{ErrorCode::TooLarge, "glb: exceeds 4 GiB, the maximum of the format; write another format"};
  std::vector<std::byte> glb;
  glb.reserve(total);
  const auto word = [&](uint32_t value) {
    const auto* bytes = reinterpret_cast<const std::byte*>(&value);
    glb.insert(glb.end(), bytes, bytes + 4);
  };
  const auto chunk = [&](uint32_t kind, std::span<const std::byte> bytes, char filler) {
    word(static_cast<uint32_t>(padded(bytes.size())));
    word(kind);
    glb.insert(glb.end(), bytes.begin(), bytes.end());
    glb.resize(padded(glb.size()), static_cast<std::byte>(filler));
  };
  word(0x46546c67);
  word(2);
  word(static_cast<uint32_t>(total));
  chunk(0x4e4f534a, std::as_bytes(std::span(json)), ' ');
  if (!binary.empty()) chunk(0x004e4942, binary, 0);
  return glb;
}

Result<std::vector<std::byte>> encode_glb(const GaussianAsset& asset, const AssetFrame& frame) {
  if (asset.size() == 0) return invalid_argument("glb: an asset without kernels cannot be written");
  GltfBuffer buffer;
  std::set<std::string> used;
  auto primitive = gltf_splat_primitive(asset, false, buffer, used);
  if (!primitive) return primitive.error();
  Json document{{"asset", {{"version", "2.0"}, {"generator", "LiveGS"}}},
                {"extensionsUsed", used},
                {"scene", 0},
                {"scenes", {{{"nodes", {0}}}}},
                {"nodes", {{{"mesh", 0}}}},
                {"meshes", {{{"primitives", Json::array({std::move(*primitive)})}}}},
                {"accessors", buffer.accessors()},
                {"bufferViews", buffer.views()},
                {"buffers", {{{"byteLength", buffer.size()}}}}};
  const std::vector<std::string> lines = y_up_frame_lines(frame);
  if (!lines.empty()) document["asset"]["extras"]["livegs"] = lines;
  return join_glb(document.dump(), buffer.take_bytes());
}

}  // namespace livegs
