// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "gaussian/asset/bytes.h"
#include "gaussian/gaussian_asset.h"

// Planes of quantised values, one property after the other; common to all versions of .spz.
// Sizes are bytes per kernel.
//   positions  9: 3 signed 24-bit numbers times 2^-fractional_bits (version 1: 3 half floats)
//   alphas     1: opacity * 255
//   colours    3: sh_dc * 0.15 * 255 + 127.5
//   scales     3: (log-scale + 10) * 16
//   rotations  version 1 and 2, 3: x y z * 127.5 + 127.5 of the quaternion with w >= 0
//              version 3 and up, 4: index of the largest of x y z w in the two top bits, then the others in
//              ascending order, a sign and nine bits of magnitude * 511 * sqrt(2) each
//   SH         3 for each coefficient of degree 1 and up, channel fastest: value * 128 + 128

namespace livegs {

inline constexpr uint32_t kSpzMagic = 0x5053474e;  // "NGSP"
inline constexpr uint8_t kSpzAntialiased = 1;
inline constexpr uint8_t kSpzHasExtensions = 2;
inline constexpr int kSpzMaxShDegree = 4;
inline constexpr float kSpzColourScale = 0.15f;

struct SpzHeader {
  uint32_t magic = kSpzMagic;
  uint32_t version = 3;
  uint32_t count = 0;
  uint8_t sh_degree = 0;
  uint8_t fractional_bits = 12;
  uint8_t flags = 0;
  uint8_t reserved = 0;  // version 4: the number of streams
};
static_assert(sizeof(SpzHeader) == 16);

enum SpzPlane { kSpzPositions, kSpzAlphas, kSpzColours, kSpzScales, kSpzRotations, kSpzSh, kSpzPlaneCount };

// Bytes per kernel in each plane.
std::array<uint64_t, kSpzPlaneCount> spz_plane_widths(const SpzHeader& header);

// Unpacks the kernels, y up as stored. Degree 4 is left out. Precondition: each plane holds its width times
// header.count bytes.
GaussianAsset unpack_spz(const SpzHeader& header, const std::array<Bytes, kSpzPlaneCount>& planes);

}  // namespace livegs
