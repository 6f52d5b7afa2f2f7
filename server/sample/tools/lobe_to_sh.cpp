// SPDX-License-Identifier: GPL-3.0-or-later
#include "sample/tools/lobe_to_sh.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace livegs::sample {
namespace {

constexpr int kPoints = 64;  // exact to degree 127, sufficient for narrow lobes

double legendre(int l, double x) {
  switch (l) {
    case 0:
      return 1.0;
    case 1:
      return x;
    case 2:
      return 0.5 * (3 * x * x - 1);
    default:
      return 0.5 * x * (5 * x * x - 3);
  }
}

struct Rule {
  std::array<double, kPoints> node, weight;
};

// Newton's method on the Legendre polynomial, from Tricomi's estimate of its roots.
Rule gauss_legendre() {
  Rule rule;
  for (int i = 0; i < kPoints; ++i) {
    double x = std::cos(std::numbers::pi * (i + 0.75) / (kPoints + 0.5)), slope = 1.0;
    for (int step = 0; step < 8; ++step) {
      double previous = 1.0, value = x;
      for (int n = 2; n <= kPoints; ++n) {
        const double next = ((2 * n - 1) * x * value - (n - 1) * previous) / n;
        previous = value;
        value = next;
      }
      slope = kPoints * (x * value - previous) / (x * x - 1);
      x -= value / slope;
    }
    rule.node[i] = x;
    rule.weight[i] = 2.0 / ((1 - x * x) * slope * slope);
  }
  return rule;
}

}  // namespace

ZonalLobe project_zonal(const std::function<double(double)>& f, int degree) {
  static const Rule rule = gauss_legendre();
  ZonalLobe lobe;
  for (int i = 0; i < kPoints; ++i)
    for (int l = 0; l <= degree; ++l)
      lobe.strength[l] += 2 * std::numbers::pi * rule.weight[i] * f(rule.node[i]) * legendre(l, rule.node[i]);
  return lobe;
}

ZonalLobe project_lobe(const std::function<double(double)>& f, int degree) {
  ZonalLobe lobe = project_zonal(f, degree);
  double peak = 0.0;
  for (int l = 0; l <= degree; ++l) {
    const double x = std::numbers::pi * l / (degree + 1.5);
    if (l > 0) lobe.strength[l] *= std::sin(x) / x;
    peak += lobe.strength[l] * (2 * l + 1) / (4 * std::numbers::pi);
  }
  for (double& strength : lobe.strength) strength *= f(1.0) / peak;
  return lobe;
}

std::array<double, 16> real_harmonics(const Eigen::Vector3d& d) {
  const double x = d.x(), y = d.y(), z = d.z(), xx = x * x, yy = y * y, zz = z * z;
  return {0.28209479177387814,
          -0.4886025119029199 * y,
          0.4886025119029199 * z,
          -0.4886025119029199 * x,
          1.0925484305920792 * x * y,
          -1.0925484305920792 * y * z,
          0.31539156525252005 * (2 * zz - xx - yy),
          -1.0925484305920792 * x * z,
          0.5462742152960396 * (xx - yy),
          -0.5900435899266435 * y * (3 * xx - yy),
          2.890611442640554 * x * y * z,
          -0.4570457994644658 * y * (4 * zz - xx - yy),
          0.3731763325901154 * z * (2 * zz - 3 * xx - 3 * yy),
          -0.4570457994644658 * x * (4 * zz - xx - yy),
          1.445305721320277 * z * (xx - yy),
          -0.5900435899266435 * x * (xx - 3 * yy)};
}

void add_lobe(const ZonalLobe& lobe, const Eigen::Vector3d& axis, const Eigen::Vector3d& colour,
              Eigen::Vector3d& dc, std::span<Eigen::Vector3d> rest) {
  static constexpr int kBand[16] = {0, 1, 1, 1, 2, 2, 2, 2, 2, 3, 3, 3, 3, 3, 3, 3};
  const std::array<double, 16> harmonics = real_harmonics(axis);
  dc += lobe.strength[0] * harmonics[0] * colour;
  for (size_t k = 0; k < rest.size(); ++k) rest[k] += lobe.strength[kBand[k + 1]] * harmonics[k + 1] * colour;
}

}  // namespace livegs::sample
