// SPDX-License-Identifier: GPL-3.0-or-later
#include "sample/tools/colour.h"

#include <algorithm>
#include <cmath>

namespace livegs::sample {

double linear_from_srgb(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

double srgb_from_linear(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

Eigen::Vector3d linear_from_hex(uint32_t rgb) {
  return {linear_from_srgb(((rgb >> 16) & 255) / 255.0), linear_from_srgb(((rgb >> 8) & 255) / 255.0),
          linear_from_srgb((rgb & 255) / 255.0)};
}

Eigen::Vector3d display_from_radiance(const Eigen::Vector3d& radiance) {
  constexpr double kKnee = 0.6;  // linear; about 0.8 on the display
  Eigen::Vector3d display;
  for (int channel = 0; channel < 3; ++channel) {
    double value = std::max(0.0, radiance[channel]);
    if (value > kKnee) value = kKnee + (1.0 - kKnee) * (1.0 - std::exp(-(value - kKnee) / (1.0 - kKnee)));
    display[channel] = srgb_from_linear(value);
  }
  return display;
}

}  // namespace livegs::sample
