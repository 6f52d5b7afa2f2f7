// SPDX-License-Identifier: Apache-2.0
#include "wire/coding/quantised_box.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace livegs {

bool QuantisedBox::is_valid() const {
  const Eigen::Vector3f max_m = min_m + edge_m;
  return min_m.allFinite() && edge_m.allFinite() && max_m.allFinite() && (edge_m.array() >= 0.0f).all();
}

Eigen::Matrix<uint32_t, 3, 1> QuantisedBox::quantise(const Eigen::Vector3d& point_m, int bits) const {
  const double last = static_cast<double>((1u << bits) - 1u);
  Eigen::Matrix<uint32_t, 3, 1> steps;
  for (int d = 0; d < 3; ++d) {
    const double edge = edge_m[d];
    const double share = edge > 0.0 ? (point_m[d] - static_cast<double>(min_m[d])) / edge : 0.0;
    steps[d] = static_cast<uint32_t>(std::floor(std::clamp(share, 0.0, 1.0) * last + 0.5));
  }
  return steps;
}

Eigen::Vector3d QuantisedBox::position_m(const Eigen::Matrix<uint32_t, 3, 1>& steps, int bits) const {
  const double last = static_cast<double>((1u << bits) - 1u);
  return min_m.cast<double>() + (steps.cast<double>() / last).cwiseProduct(edge_m.cast<double>());
}

QuantisedBox box_around(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  QuantisedBox box;
  for (int d = 0; d < 3; ++d) {
    float min = static_cast<float>(low[d]);
    if (static_cast<double>(min) > low[d]) min = std::nextafter(min, -kInfinity);
    const double wanted = high[d] - static_cast<double>(min);
    float edge = static_cast<float>(wanted);
    if (static_cast<double>(edge) < wanted) edge = std::nextafter(edge, kInfinity);
    box.min_m[d] = min;
    box.edge_m[d] = edge;
  }
  return box;
}

}  // namespace livegs
