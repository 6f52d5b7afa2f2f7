// SPDX-License-Identifier: Apache-2.0
// The layout is described in compressed_ply_reader.cpp.
#include <algorithm>
#include <cmath>
#include <string>

#include "gaussian/asset/bytes.h"
#include "gaussian/asset/morton_order.h"
#include "gaussian/asset/smallest_three.h"
#include "gaussian/asset_file.h"
#include "gaussian/opacity.h"

namespace livegs {
namespace {

constexpr size_t kKernelsOfChunk = 256;
constexpr float kMaxPackedLogScale = 20;

// The bounds of one property within a chunk.
struct Range {
  Eigen::Vector3f low = Eigen::Vector3f::Constant(INFINITY), high = -low;
  void add(const Eigen::Vector3f& value) {
    low = low.cwiseMin(value);
    high = high.cwiseMax(value);
  }
  uint32_t step(const Eigen::Vector3f& value, int axis, float steps) const {
    const float side = high[axis] - low[axis];
    const float share = side > 0 ? (value[axis] - low[axis]) / side : 0;
    return static_cast<uint32_t>(std::lround(std::clamp(share, 0.0f, 1.0f) * steps));
  }
  uint32_t packed(const Eigen::Vector3f& value) const {
    return step(value, 0, 2047) << 21 | step(value, 1, 1023) << 11 | step(value, 2, 2047);
  }
};

Eigen::Vector3f packed_scale_of(const Eigen::Vector3f& log_scale) {
  return log_scale.cwiseMax(-kMaxPackedLogScale).cwiseMin(kMaxPackedLogScale);
}

Eigen::Vector3f rgb_of(const Eigen::Vector3f& dc) { return (dc.array() * kShBand0 + 0.5f).matrix(); }

uint32_t packed_rotation(const Eigen::Quaternionf& q) {
  const SmallestThree three = to_smallest_three({q.w(), q.x(), q.y(), q.z()});
  uint32_t word = three.largest;
  for (const float value : three.others) {
    const float share = std::clamp(value / (2 * kSqrtHalf) + 0.5f, 0.0f, 1.0f);
    word = word << 10 | static_cast<uint32_t>(std::lround(share * 1023));
  }
  return word;
}

// Inverse of the reader's steps: bytes 1 to 254 stand for the middle of 1/32, the outermost for +-4.
uint8_t packed_sh(float value) {
  const float step = std::floor((value / 8 + 0.5f) * 256);
  const int byte = static_cast<int>(std::clamp(step, 0.0f, 255.0f));
  const float half = 4 - 3.0f / 128;  // the middle between 4 and the last step but one
  if (byte == 0 && value > -half) return 1;
  if (byte == 255 && value < half) return 254;
  return static_cast<uint8_t>(byte);
}

std::string compressed_header(const GaussianAsset& asset, const AssetFrame& frame, size_t chunks) {
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  if (asset.antialiased) header += "comment SplatRenderMode: mip\n";
  for (const std::string& line : frame_lines(frame, false)) header += "comment " + line + "\n";
  header += "element chunk " + std::to_string(chunks) + "\n";
  for (const char* property : {"", "scale_"}) {
    for (const char* bound : {"min_", "max_"}) {
      for (const char* axis : {"x", "y", "z"})
        header += std::string("property float ") + bound + property + axis + "\n";
    }
  }
  for (const char* bound : {"min_", "max_"}) {
    for (const char* channel : {"r", "g", "b"})
      header += std::string("property float ") + bound + channel + "\n";
  }
  header += "element vertex " + std::to_string(asset.size()) + "\n";
  for (const char* word : {"position", "rotation", "scale", "color"})
    header += std::string("property uint packed_") + word + "\n";
  if (asset.sh_degree > 0) {
    header += "element sh " + std::to_string(asset.size()) + "\n";
    for (size_t i = 0; i < 3 * asset.sh_rest_count(); ++i)
      header += "property uchar f_rest_" + std::to_string(i) + "\n";
  }
  return header + "end_header\n";
}

}  // namespace

Result<std::vector<std::byte>> encode_compressed_ply(const GaussianAsset& asset, const AssetFrame& frame) {
  if (asset.size() == 0)
    return invalid_argument("compressed.ply: an asset without kernels cannot be written");
  const std::vector<uint32_t> order = morton_order(asset);
  const size_t chunks = (asset.size() + kKernelsOfChunk - 1) / kKernelsOfChunk;
  const std::string header = compressed_header(asset, frame, chunks);
  std::vector<std::byte> bytes, vertices;
  const Bytes text = std::as_bytes(std::span(header));
  bytes.insert(bytes.end(), text.begin(), text.end());
  for (size_t begin = 0; begin < order.size(); begin += kKernelsOfChunk) {
    const std::span<const uint32_t> chunk =
        std::span(order).subspan(begin, std::min(kKernelsOfChunk, order.size() - begin));
    Range position, scale, rgb;
    for (const uint32_t i : chunk) {
      position.add(asset.positions[i]);
      scale.add(packed_scale_of(asset.log_scales[i]));
      rgb.add(rgb_of(asset.sh_dc[i]));
    }
    for (const Range& range : {position, scale, rgb}) {
      for (const float value : range.low) append(bytes, value);
      for (const float value : range.high) append(bytes, value);
    }
    for (const uint32_t i : chunk) {
      append(vertices, position.packed(asset.positions[i]));
      append(vertices, packed_rotation(asset.rotations[i]));
      append(vertices, scale.packed(packed_scale_of(asset.log_scales[i])));
      const Eigen::Vector3f colour = rgb_of(asset.sh_dc[i]);
      const auto opacity =
          static_cast<uint32_t>(std::lround(opacity_of_logit(asset.opacity_logits[i]) * 255));
      append(vertices, rgb.step(colour, 0, 255) << 24 | rgb.step(colour, 1, 255) << 16 |
                           rgb.step(colour, 2, 255) << 8 | opacity);
    }
  }
  bytes.insert(bytes.end(), vertices.begin(), vertices.end());
  const size_t rest = asset.sh_rest_count();
  for (const uint32_t i : order) {
    for (int channel = 0; channel < 3; ++channel) {
      for (size_t k = 0; k < rest; ++k) append(bytes, packed_sh(asset.sh_rest[i * rest + k][channel]));
    }
  }
  return bytes;
}

}  // namespace livegs
