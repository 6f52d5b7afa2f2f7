// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace livegs::sample {

// Colours are linear-light RGB until a kernel is written; kernels store display-encoded sRGB.

// Converts a display colour 0xRRGGBB to linear light.
Eigen::Vector3d linear_from_hex(uint32_t rgb);

// IEC 61966-2-1, one channel, 0..1.
double linear_from_srgb(double encoded);
double srgb_from_linear(double linear);

// Converts linear radiance to display values in 0..1: identity in the mid-tones, with a soft shoulder above
// 0.7 so that bright surfaces keep their hue instead of clipping.
Eigen::Vector3d display_from_radiance(const Eigen::Vector3d& radiance);

inline Eigen::Vector3d blend(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double share) {
  return from + (to - from) * share;
}

}  // namespace livegs::sample
