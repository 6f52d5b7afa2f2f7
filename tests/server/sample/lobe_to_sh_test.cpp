// SPDX-License-Identifier: Apache-2.0
#include "sample/tools/lobe_to_sh.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

namespace livegs::sample {
namespace {

constexpr double kPi = 3.14159265358979323846;

// Equal-area directions on the sphere.
std::vector<Eigen::Vector3d> directions(int count) {
  std::vector<Eigen::Vector3d> out;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count, r = std::sqrt(1 - z * z), a = 2.399963229728653 * i;
    out.emplace_back(r * std::cos(a), r * std::sin(a), z);
  }
  return out;
}

double evaluate(const Eigen::Vector3d& dc, std::span<const Eigen::Vector3d> rest,
                const Eigen::Vector3d& direction) {
  const std::array<double, 16> y = real_harmonics(direction);
  double value = y[0] * dc.x();
  for (size_t k = 0; k < rest.size(); ++k) value += y[k + 1] * rest[k].x();
  return value;
}

TEST(LobeToSh, HarmonicsAreOrthonormal) {
  const auto sphere = directions(20000);
  for (int i = 0; i < 16; ++i)
    for (int j = i; j < 16; ++j) {
      double sum = 0.0;
      for (const Eigen::Vector3d& d : sphere) sum += real_harmonics(d)[i] * real_harmonics(d)[j];
      sum *= 4 * kPi / static_cast<double>(sphere.size());
      // A Fibonacci lattice integrates smooth functions with an error of about 1 / count.
      EXPECT_NEAR(sum, i == j ? 1.0 : 0.0, 2e-3) << i << " " << j;
    }
}

TEST(LobeToSh, BandLimitedFunctionIsReproduced) {
  const auto f = [](double c) { return 0.2 - 0.7 * c + 1.3 * c * c + 0.4 * c * c * c; };
  const ZonalLobe lobe = project_zonal(f, 3);
  const Eigen::Vector3d axis = Eigen::Vector3d(0.3, -0.8, 0.52).normalized();
  Eigen::Vector3d dc = Eigen::Vector3d::Zero();
  std::array<Eigen::Vector3d, 15> rest;
  rest.fill(Eigen::Vector3d::Zero());
  add_lobe(lobe, axis, Eigen::Vector3d::Ones(), dc, rest);
  // Degree 3 is represented completely and the quadrature is exact for it: rounding only.
  for (const Eigen::Vector3d& d : directions(200)) EXPECT_NEAR(evaluate(dc, rest, d), f(axis.dot(d)), 1e-10);
}

TEST(LobeToSh, HighlightKeepsItsHeightAndPeaksOnItsAxis) {
  for (int degree = 1; degree <= 3; ++degree) {
    const ZonalLobe lobe = project_lobe([](double c) { return std::exp((c - 1) / 0.01); }, degree);
    const Eigen::Vector3d axis = Eigen::Vector3d(-0.5, 0.1, 0.86).normalized();
    Eigen::Vector3d dc = Eigen::Vector3d::Zero();
    std::vector<Eigen::Vector3d> rest((degree + 1) * (degree + 1) - 1, Eigen::Vector3d::Zero());
    add_lobe(lobe, axis, Eigen::Vector3d::Constant(0.6), dc, rest);
    EXPECT_NEAR(evaluate(dc, rest, axis), 0.6, 1e-9);
    for (const Eigen::Vector3d& d : directions(500)) EXPECT_LE(evaluate(dc, rest, d), 0.6 + 1e-9);
  }
}

}  // namespace
}  // namespace livegs::sample
