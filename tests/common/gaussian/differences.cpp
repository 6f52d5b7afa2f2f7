// SPDX-License-Identifier: Apache-2.0
#include "common/gaussian/differences.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "gaussian/opacity.h"

namespace livegs {
namespace {

float largest(const Eigen::Vector3f& difference) { return difference.cwiseAbs().maxCoeff(); }

// Difference of two kernels apart from position; 0: equal.
float unlikeness(const GaussianAsset& a, size_t i, const GaussianAsset& b, size_t j) {
  return (a.positions[i] - b.positions[j]).norm() + (a.log_scales[i] - b.log_scales[j]).norm() +
         (a.sh_dc[i] - b.sh_dc[j]).norm() +
         std::abs(opacity_of_logit(a.opacity_logits[i]) - opacity_of_logit(b.opacity_logits[j]));
}

}  // namespace

Differences differences(const GaussianAsset& a, const GaussianAsset& b, const std::vector<size_t>& partner) {
  Differences worst;
  const size_t rest = a.sh_rest_count();
  for (size_t i = 0; i < a.size(); ++i) {
    const size_t j = partner[i];
    worst.position = std::max(worst.position, largest(a.positions[i] - b.positions[j]));
    worst.log_scale = std::max(worst.log_scale, largest(a.log_scales[i] - b.log_scales[j]));
    const Eigen::Quaterniond turn = a.rotations[i].cast<double>().conjugate() * b.rotations[j].cast<double>();
    const double angle_rad = 2 * std::atan2(turn.vec().norm(), std::abs(turn.w()));
    worst.rotation_deg = std::max(worst.rotation_deg, static_cast<float>(angle_rad * 180 / M_PI));
    const float opacity = opacity_of_logit(a.opacity_logits[i]) - opacity_of_logit(b.opacity_logits[j]);
    worst.opacity = std::max(worst.opacity, std::abs(opacity));
    if (b.opacity_logits[j] > -kMaxOpacityLogit) {
      const Eigen::Vector3f colour = a.sh_dc[i] - b.sh_dc[j];
      worst.sh_dc = std::max(worst.sh_dc, largest(colour));
      worst.mean_sh_dc += colour.cwiseAbs().sum();
    }
    for (size_t k = 0; k < rest; ++k) {
      float& band = k < 3 ? worst.sh1 : worst.sh_rest;
      const Eigen::Vector3f difference = a.sh_rest[i * rest + k] - b.sh_rest[j * rest + k];
      band = std::max(band, largest(difference));
      worst.mean_sh += difference.cwiseAbs().sum();
    }
    worst.mean_log_scale += (a.log_scales[i] - b.log_scales[j]).cwiseAbs().sum();
  }
  worst.mean_log_scale /= 3.0 * static_cast<double>(a.size());
  worst.mean_sh_dc /= 3.0 * static_cast<double>(a.size());
  if (rest) worst.mean_sh /= 3.0 * static_cast<double>(a.size() * rest);
  return worst;
}

std::vector<size_t> same_order(size_t count) {
  std::vector<size_t> order(count);
  std::iota(order.begin(), order.end(), size_t{0});
  return order;
}

std::vector<size_t> match_by_position(const GaussianAsset& a, const GaussianAsset& b, float radius) {
  std::vector<size_t> by_x = same_order(b.size());
  std::sort(by_x.begin(), by_x.end(), [&](size_t i, size_t j) {
    return b.positions[i].x() != b.positions[j].x() ? b.positions[i].x() < b.positions[j].x() : i < j;
  });
  std::vector<bool> taken(b.size(), false);
  std::vector<size_t> partner(a.size());
  for (size_t i = 0; i < a.size(); ++i) {
    const Eigen::Vector3f& p = a.positions[i];
    auto candidate = std::lower_bound(by_x.begin(), by_x.end(), p.x() - radius,
                                      [&](size_t j, float x) { return b.positions[j].x() < x; });
    float best = std::numeric_limits<float>::infinity();
    size_t found = b.size();
    for (; candidate != by_x.end() && b.positions[*candidate].x() <= p.x() + radius; ++candidate) {
      if (taken[*candidate] || largest(b.positions[*candidate] - p) > radius) continue;
      const float score = unlikeness(a, i, b, *candidate);
      if (score < best) best = score, found = *candidate;
    }
    if (found == b.size()) return {};
    taken[found] = true;
    partner[i] = found;
  }
  return partner;
}

}  // namespace livegs
