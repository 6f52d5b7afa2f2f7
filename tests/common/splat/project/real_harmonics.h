// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "common/splat/synthetic_kernels.h"

// The image of a kernel with a single harmonic, computed in doubles from the definition, independent of the
// product code.

namespace livegs::synthetic {

inline constexpr int kBandCoefficients = 15;  // of degrees 1 to 3, in the order of GaussianAsset::sh_rest

// The real spherical harmonic of degree l and order m, with the Condon-Shortley phase (Abramowitz and
// Stegun 8.5.3, 8.6.6): sqrt 2 N P_l^|m|(cos theta) times sin or cos of |m| phi, theta from +z, phi from +x
// to +y.
inline double real_harmonic(int l, int m, const Eigen::Vector3d& direction) {
  const int order = std::abs(m);
  const double z = direction.normalized().z(), across = std::sqrt(std::max(0.0, 1 - z * z));
  double diagonal = 1;  // P_order^order
  for (int i = 1; i <= order; ++i) diagonal *= -(2 * i - 1) * across;
  double before = 0, legendre = diagonal;
  for (int n = order + 1; n <= l; ++n) {
    const double next = ((2 * n - 1) * z * legendre - (n + order - 1) * before) / (n - order);
    before = legendre;
    legendre = next;
  }
  double factorials = 1;  // (l - order)! / (l + order)!
  for (int i = l - order + 1; i <= l + order; ++i) factorials /= i;
  const double norm = std::sqrt((2 * l + 1) / (4 * M_PI) * factorials);
  const double azimuth = std::atan2(direction.y(), direction.x());
  if (order == 0) return norm * legendre;
  return std::sqrt(2.0) * norm * legendre * (m < 0 ? std::sin(order * azimuth) : std::cos(order * azimuth));
}

// The harmonic of coefficient k of sh_rest.
inline double real_harmonic(int k, const Eigen::Vector3d& direction) {
  const int l = k < 3 ? 1 : k < 8 ? 2 : 3;
  return real_harmonic(l, k - (l * l - 1) - l, direction);
}

inline constexpr double kBandOpacity = 0.9;
// Values per channel: exact as halves; the last one is clamped at 0 over much of the sphere.
inline const Eigen::Vector3d kBandValues{0.375, -0.4375, 1.5};

// One kernel, grey except for coefficient k, that covers the centre of every image here.
inline GaussianAsset one_harmonic(int k, const Eigen::Vector3d& position_m = Eigen::Vector3d::Zero()) {
  Object object;
  object.asset.sh_degree = 3;
  add_ball(object, position_m, 0.3, kBandOpacity, Eigen::Vector3d::Constant(0.5));
  object.asset.sh_rest[static_cast<size_t>(k)] = kBandValues.cast<float>();
  return object.asset;
}

// The colour at its centre over black, seen along `direction` (world), for an asset rotated by
// `world_from_asset`.
inline Eigen::Vector3d one_harmonic_shows(int k, const Eigen::Quaterniond& world_from_asset,
                                          const Eigen::Vector3d& direction) {
  const double y = real_harmonic(k, world_from_asset.conjugate() * direction.normalized());
  return kBandOpacity * (0.5 + kBandValues.array() * y).max(0.0);
}

// A camera 2 m from a point; the centre pixel, (16, 12), looks at the point.
inline Camera eye_towards(const Eigen::Vector3d& point_m, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d up =
      std::abs(direction.normalized().y()) < 0.9 ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitX();
  return look_at(point_m - 2 * direction.normalized(), point_m, up, 0.8, 33, 25);
}

}  // namespace livegs::synthetic
