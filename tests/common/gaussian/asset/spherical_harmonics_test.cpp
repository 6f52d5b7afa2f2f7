// SPDX-License-Identifier: Apache-2.0
#include "gaussian/spherical_harmonics.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

namespace livegs {
namespace {

std::array<double, 16> basis(const Eigen::Vector3f& direction) {
  float bands[15];
  evaluate_sh_bands(direction, 3, bands);
  std::array<double, 16> values{kShDc};
  for (int k = 0; k < 15; ++k) values[k + 1] = bands[k];
  return values;
}

TEST(SphericalHarmonics, AreOrthonormal) {
  // Gauss-Legendre with four nodes is exact to degree 7 in z, the trapezoid rule with eight to order 7 in
  // azimuth. Products of two harmonics of degree 3 need less.
  constexpr std::array<double, 4> kNodes{-0.8611363115940526, -0.3399810435848563, 0.3399810435848563,
                                         0.8611363115940526};
  constexpr std::array<double, 4> kWeights{0.3478548451374538, 0.6521451548625461, 0.6521451548625461,
                                           0.3478548451374538};
  double gram[16][16] = {};
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 8; ++j) {
      const double azimuth = 2.0 * M_PI * (j + 0.3) / 8.0, across = std::sqrt(1.0 - kNodes[i] * kNodes[i]);
      const Eigen::Vector3d direction(across * std::cos(azimuth), across * std::sin(azimuth), kNodes[i]);
      const auto values = basis(direction.cast<float>());
      for (int a = 0; a < 16; ++a) {
        for (int b = 0; b < 16; ++b) gram[a][b] += kWeights[i] * 2.0 * M_PI / 8.0 * values[a] * values[b];
      }
    }
  }
  for (int a = 0; a < 16; ++a) {
    for (int b = 0; b < 16; ++b)
      EXPECT_NEAR(gram[a][b], a == b ? 1.0 : 0.0, 2e-6) << a << " " << b;  // float terms
  }
}

// Kernels show the sum of all bands. A renderer that clamps the constant term first would show 0.3 here
// instead of 0.1.
TEST(SphericalHarmonics, AreSummedBeforeTheClamp) {
  const Eigen::Vector3f dc = Eigen::Vector3f::Constant((-0.2f - 0.5f) / kShDc);
  Eigen::Vector3f rest[3] = {Eigen::Vector3f::Zero(), Eigen::Vector3f::Constant(0.3f / 0.48860251f),
                             Eigen::Vector3f::Zero()};
  const Eigen::Vector3f colour = evaluate_sh_colour(dc, rest, 1, Eigen::Vector3f::UnitZ());
  EXPECT_NEAR(colour.x(), 0.1f, 1e-6f);
  const Eigen::Vector3f behind = evaluate_sh_colour(dc, rest, 1, -Eigen::Vector3f::UnitZ());
  EXPECT_EQ(behind.x(), 0.0f);
}

TEST(SphericalHarmonics, ClampEachChannel) {
  const Eigen::Vector3f dc = Eigen::Vector3f::Constant(-3.0f);
  EXPECT_EQ(evaluate_sh_colour(dc, nullptr, 0, Eigen::Vector3f::UnitX()), Eigen::Vector3f(0, 0, 0));
}

TEST(SphericalHarmonics, ColoursAboveOneAreKept) {
  const Eigen::Vector3f dc = Eigen::Vector3f::Constant(1.0f / kShDc);
  EXPECT_NEAR(evaluate_sh_colour(dc, nullptr, 0, Eigen::Vector3f::UnitX()).y(), 1.5f, 1e-6f);
}

TEST(SphericalHarmonics, NeverGiveNan) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(evaluate_sh_colour({nan, 0, 0}, nullptr, 0, Eigen::Vector3f::UnitX()).x(), 0.0f);
}

}  // namespace
}  // namespace livegs
