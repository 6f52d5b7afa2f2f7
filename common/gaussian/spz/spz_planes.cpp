// SPDX-License-Identifier: Apache-2.0
#include "gaussian/spz/spz_planes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "gaussian/asset/smallest_three.h"
#include "gaussian/opacity.h"

namespace livegs {
namespace {

float from_half(uint16_t half) {
  const int exponent = (half >> 10) & 31;
  const auto mantissa = static_cast<float>(half & 1023);
  float magnitude = 0;
  if (exponent == 31) {
    magnitude =
        mantissa == 0 ? std::numeric_limits<float>::infinity() : std::numeric_limits<float>::quiet_NaN();
  } else {
    magnitude = exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(mantissa + 1024, exponent - 25);
  }
  return half & 0x8000 ? -magnitude : magnitude;
}

int32_t signed_24(Bytes bytes, size_t offset) {
  const uint32_t word =
      byte_at(bytes, offset) << 8 | byte_at(bytes, offset + 1) << 16 | byte_at(bytes, offset + 2) << 24;
  return static_cast<int32_t>(word) >> 8;
}

Eigen::Quaternionf first_three(Bytes bytes, size_t offset) {
  const auto component = [&](size_t i) {
    return static_cast<float>(byte_at(bytes, offset + i)) / 127.5f - 1.0f;
  };
  const float x = component(0), y = component(1), z = component(2);
  return {std::sqrt(std::max(0.0f, 1.0f - (x * x + y * y + z * z))), x, y, z};
}

Eigen::Quaternionf smallest_three(uint32_t word) {
  const auto component = [](uint32_t bits) {
    const float magnitude = static_cast<float>(bits & 511) / 511.0f * kSqrtHalf;
    return bits & 512 ? -magnitude : magnitude;
  };
  const Eigen::Vector4f xyzw =
      from_smallest_three(word >> 30, {component(word >> 20), component(word >> 10), component(word)});
  return Eigen::Quaternionf(xyzw);
}

Eigen::Vector3f bytes_3(Bytes plane, size_t i) {
  return {static_cast<float>(byte_at(plane, 3 * i)), static_cast<float>(byte_at(plane, 3 * i + 1)),
          static_cast<float>(byte_at(plane, 3 * i + 2))};
}

}  // namespace

std::array<uint64_t, kSpzPlaneCount> spz_plane_widths(const SpzHeader& header) {
  const uint64_t rest = (header.sh_degree + 1u) * (header.sh_degree + 1u) - 1;
  return {header.version == 1 ? 6u : 9u, 1, 3, 3, header.version >= 3 ? 4u : 3u, 3 * rest};
}

GaussianAsset unpack_spz(const SpzHeader& header, const std::array<Bytes, kSpzPlaneCount>& planes) {
  GaussianAsset asset;
  asset.sh_degree = std::min<int>(header.sh_degree, 3);
  asset.antialiased = header.flags & kSpzAntialiased;
  asset.resize(header.count);

  const Bytes positions = planes[kSpzPositions];
  const float step = std::ldexp(1.0f, -header.fractional_bits);
  for (size_t i = 0; i < asset.size(); ++i) {
    for (size_t axis = 0; axis < 3; ++axis) {
      const size_t n = 3 * i + axis;
      asset.positions[i][static_cast<int>(axis)] =
          header.version == 1 ? from_half(load<uint16_t>(positions, 2 * n))
                              : static_cast<float>(signed_24(positions, 3 * n)) * step;
    }
    asset.opacity_logits[i] = logit_of_opacity_byte(byte_at(planes[kSpzAlphas], i));
    asset.sh_dc[i] = (bytes_3(planes[kSpzColours], i).array() / 255.0f - 0.5f) / kSpzColourScale;
    asset.log_scales[i] = bytes_3(planes[kSpzScales], i).array() / 16.0f - 10.0f;
    asset.rotations[i] = header.version >= 3 ? smallest_three(load<uint32_t>(planes[kSpzRotations], 4 * i))
                                             : first_three(planes[kSpzRotations], 3 * i);
  }
  const size_t rest = asset.sh_rest_count();
  const size_t stored = (header.sh_degree + 1u) * (header.sh_degree + 1u) - 1;
  for (size_t i = 0; i < asset.size(); ++i) {
    for (size_t k = 0; k < rest; ++k) {
      asset.sh_rest[i * rest + k] = (bytes_3(planes[kSpzSh], i * stored + k).array() - 128.0f) / 128.0f;
    }
  }
  return asset;
}

}  // namespace livegs
