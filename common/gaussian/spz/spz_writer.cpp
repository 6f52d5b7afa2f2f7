// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "gaussian/asset/bytes.h"
#include "gaussian/asset/decompress.h"
#include "gaussian/asset/smallest_three.h"
#include "gaussian/asset/y_up.h"
#include "gaussian/asset_file.h"
#include "gaussian/opacity.h"
#include "gaussian/spz/spz_extensions.h"
#include "gaussian/spz/spz_planes.h"

namespace livegs {
namespace {

constexpr float kMaxSigned24 = 8388607.0f;

using Planes = std::array<std::vector<std::byte>, kSpzPlaneCount>;

uint8_t to_byte(float value) { return static_cast<uint8_t>(std::clamp(std::round(value), 0.0f, 255.0f)); }

// The requested number of fractional bits, or fewer if the farthest kernel does not fit 24 bits. Negative if
// no number fits.
int fitting_fractional_bits(const GaussianAsset& asset, int wanted) {
  float farthest = 0;
  for (const Eigen::Vector3f& position : asset.positions)
    farthest = std::max(farthest, position.cwiseAbs().maxCoeff());
  int bits = wanted;
  while (bits >= 0 && std::ldexp(farthest, bits) > kMaxSigned24) --bits;
  return bits;
}

void append_position(std::vector<std::byte>& plane, const Eigen::Vector3f& position, int fractional_bits) {
  for (const float coordinate : position) {
    const auto fixed =
        static_cast<uint32_t>(static_cast<int32_t>(std::round(std::ldexp(coordinate, fractional_bits))));
    for (int shift = 0; shift < 24; shift += 8) append(plane, static_cast<uint8_t>(fixed >> shift));
  }
}

void append_first_three(std::vector<std::byte>& plane, const Eigen::Quaternionf& rotation) {
  const float sign = rotation.w() < 0 ? -1.0f : 1.0f;
  for (const float component : rotation.vec()) append(plane, to_byte(sign * component * 127.5f + 127.5f));
}

void append_smallest_three(std::vector<std::byte>& plane, const Eigen::Quaternionf& rotation) {
  const Eigen::Vector4f xyzw = rotation.coeffs();
  int largest = 0;
  xyzw.cwiseAbs().maxCoeff(&largest);
  const bool negate = xyzw[largest] < 0;
  auto word = static_cast<uint32_t>(largest);
  for (int i = 0; i < 4; ++i) {
    if (i == largest) continue;
    const auto magnitude =
        static_cast<uint32_t>(std::min(511.0f, std::round(std::abs(xyzw[i]) / kSqrtHalf * 511.0f)));
    const bool negative = (xyzw[i] < 0) != negate;
    word = word << 10 | (negative ? 512u : 0u) | magnitude;
  }
  append(plane, word);
}

// Rounds to the middle of a bucket of 2^(8 - bits) steps, so that fewer distinct bytes remain to compress.
uint8_t quantise_sh(float value, int bits) {
  const int bucket = 1 << (8 - bits);
  const int byte = static_cast<int>(std::round(std::clamp(value, -2.0f, 2.0f) * 128.0f)) + 128;
  const int rounded =
      static_cast<int>(std::floor(static_cast<float>(byte + bucket / 2) / static_cast<float>(bucket))) *
      bucket;
  return static_cast<uint8_t>(std::clamp(rounded, 0, 255));
}

Planes pack(const GaussianAsset& asset, const SpzHeader& header, const SpzOptions& options) {
  Planes planes;
  const std::array<uint64_t, kSpzPlaneCount> widths = spz_plane_widths(header);
  for (size_t p = 0; p < kSpzPlaneCount; ++p) planes[p].reserve(widths[p] * asset.size());
  const size_t rest = asset.sh_rest_count();
  for (size_t i = 0; i < asset.size(); ++i) {
    append_position(planes[kSpzPositions], asset.positions[i], header.fractional_bits);
    append(planes[kSpzAlphas], to_byte(opacity_of_logit(asset.opacity_logits[i]) * 255.0f));
    for (const float dc : asset.sh_dc[i])
      append(planes[kSpzColours], to_byte(dc * kSpzColourScale * 255.0f + 127.5f));
    for (const float scale : asset.log_scales[i])
      append(planes[kSpzScales], to_byte((scale + 10.0f) * 16.0f));
    if (header.version >= 3) {
      append_smallest_three(planes[kSpzRotations], asset.rotations[i]);
    } else {
      append_first_three(planes[kSpzRotations], asset.rotations[i]);
    }
    for (size_t k = 0; k < rest; ++k) {
      const int bits = k < 3 ? options.sh1_bits : options.sh_rest_bits;
      for (const float value : asset.sh_rest[i * rest + k]) append(planes[kSpzSh], quantise_sh(value, bits));
    }
  }
  return planes;
}

std::vector<std::byte> gzipped(const SpzHeader& header, const Planes& planes, Bytes extensions) {
  std::vector<std::byte> all;
  append(all, header);
  for (const std::vector<std::byte>& plane : planes) all.insert(all.end(), plane.begin(), plane.end());
  all.insert(all.end(), extensions.begin(), extensions.end());
  return gzip(all);
}

std::vector<std::byte> in_streams(SpzHeader header, const Planes& planes, Bytes extensions) {
  std::vector<std::byte> table;
  std::vector<std::byte> streams;
  header.reserved = 0;
  for (const std::vector<std::byte>& plane : planes) {
    if (plane.empty()) continue;
    const std::vector<std::byte> stream = zstd_compress(plane);
    append(table, static_cast<uint64_t>(stream.size()));
    append(table, static_cast<uint64_t>(plane.size()));
    streams.insert(streams.end(), stream.begin(), stream.end());
    ++header.reserved;
  }
  std::vector<std::byte> file;
  append(file, header);
  append(file, static_cast<uint32_t>(32 + extensions.size()));  // offset of the table
  append(file, std::array<uint8_t, 12>{});                      // reserved
  file.insert(file.end(), extensions.begin(), extensions.end());
  file.insert(file.end(), table.begin(), table.end());
  file.insert(file.end(), streams.begin(), streams.end());
  return file;
}

}  // namespace

Result<std::vector<std::byte>> encode_spz(const GaussianAsset& asset, const SpzOptions& options,
                                          const AssetFrame& frame) {
  if (options.version < 2 || options.version > 4) {
    return invalid_argument("spz version " + std::to_string(options.version) +
                            " cannot be written; choose 2, 3 or 4");
  }
  if (options.sh1_bits < 1 || options.sh1_bits > 8 || options.sh_rest_bits < 1 || options.sh_rest_bits > 8) {
    return invalid_argument("spz: SH coefficients must keep 1 to 8 bits");
  }
  if (options.fractional_bits < 0 || options.fractional_bits > 24) {
    return invalid_argument("spz: positions must have 0 to 24 fractional bits");
  }
  if (asset.size() == 0) return invalid_argument("spz: an asset without kernels cannot be written");
  const int fractional_bits = fitting_fractional_bits(asset, options.fractional_bits);
  if (fractional_bits < 0 || asset.size() > std::numeric_limits<uint32_t>::max() / 96) {
    return invalid_argument(
        "spz: the asset is too wide (over 8,388,607 units) or too large (over 44 million kernels); write "
        ".ply");
  }
  SpzHeader header;
  header.version = static_cast<uint32_t>(options.version);
  header.count = static_cast<uint32_t>(asset.size());
  header.sh_degree = static_cast<uint8_t>(asset.sh_degree);
  header.fractional_bits = static_cast<uint8_t>(fractional_bits);
  const std::vector<std::byte> extensions = spz_frame_record(frame);
  header.flags = asset.antialiased ? kSpzAntialiased : 0;
  if (!extensions.empty()) header.flags |= kSpzHasExtensions;

  GaussianAsset y_up = asset;
  turn_half_about_x(y_up);
  const Planes planes = pack(y_up, header, options);
  return options.version == 4 ? in_streams(header, planes, extensions) : gzipped(header, planes, extensions);
}

}  // namespace livegs
