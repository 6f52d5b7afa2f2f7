// SPDX-License-Identifier: GPL-3.0-or-later
#include "sample/tools/profile.h"

#include <algorithm>
#include <cmath>

namespace livegs::sample {
namespace {

constexpr int kStepsPerSpan = 32;
constexpr int kEvenPoints = 1024;

// Barry and Goldman's evaluation with knots at the square root of the chord length; coincident points give
// straight ends.
Eigen::Vector2d span_point(const Eigen::Vector2d p[4], double share) {
  double knot[4] = {0, 0, 0, 0};
  for (int i = 1; i < 4; ++i) knot[i] = knot[i - 1] + std::sqrt((p[i] - p[i - 1]).norm());
  const double t = knot[1] + (knot[2] - knot[1]) * share;
  const auto mix = [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b, double from, double to) {
    return to - from < 1e-9 ? a : Eigen::Vector2d(a + (b - a) * ((t - from) / (to - from)));
  };
  const Eigen::Vector2d a1 = knot[1] - knot[0] < 1e-9 ? p[1] : mix(p[0], p[1], knot[0], knot[1]);
  const Eigen::Vector2d a2 = mix(p[1], p[2], knot[1], knot[2]);
  const Eigen::Vector2d a3 = knot[3] - knot[2] < 1e-9 ? p[2] : mix(p[2], p[3], knot[2], knot[3]);
  const Eigen::Vector2d b1 = mix(a1, a2, knot[0], knot[2]);
  const Eigen::Vector2d b2 = mix(a2, a3, knot[1], knot[3]);
  return mix(b1, b2, knot[1], knot[2]);
}

}  // namespace

Profile::Profile(const std::vector<Eigen::Vector2d>& points_m) {
  std::vector<Eigen::Vector2d> dense;
  const int count = static_cast<int>(points_m.size());
  for (int i = 0; i + 1 < count; ++i) {
    if ((points_m[i + 1] - points_m[i]).norm() < 1e-12) continue;
    const Eigen::Vector2d p[4] = {points_m[std::max(0, i - 1)], points_m[i], points_m[i + 1],
                                  points_m[std::min(count - 1, i + 2)]};
    for (int step = 0; step < kStepsPerSpan; ++step)
      dense.push_back(span_point(p, static_cast<double>(step) / kStepsPerSpan));
  }
  dense.push_back(points_m.back());
  std::vector<double> travelled_m(dense.size(), 0.0);
  for (size_t i = 1; i < dense.size(); ++i)
    travelled_m[i] = travelled_m[i - 1] + (dense[i] - dense[i - 1]).norm();
  length_m_ = travelled_m.back();
  size_t segment = 1;
  for (int i = 0; i <= kEvenPoints; ++i) {
    const double wanted_m = length_m_ * i / kEvenPoints;
    while (segment + 1 < dense.size() && travelled_m[segment] < wanted_m) ++segment;
    const double step_m = travelled_m[segment] - travelled_m[segment - 1];
    const double share = step_m > 0 ? (wanted_m - travelled_m[segment - 1]) / step_m : 0.0;
    points_m_.push_back(dense[segment - 1] +
                        (dense[segment] - dense[segment - 1]) * std::clamp(share, 0.0, 1.0));
  }
}

Eigen::Vector2d Profile::at(double t) const {
  const double place = std::clamp(t, 0.0, 1.0) * kEvenPoints;
  const int index = std::min(static_cast<int>(place), kEvenPoints - 1);
  return points_m_[index] + (points_m_[index + 1] - points_m_[index]) * (place - index);
}

double Profile::radius_at(double height_m, double t_from, double t_to) const {
  double radius_m = -1.0;
  const int from = static_cast<int>(t_from * kEvenPoints), to = static_cast<int>(t_to * kEvenPoints);
  for (int i = from; i < to; ++i) {
    const Eigen::Vector2d &a = points_m_[i], &b = points_m_[i + 1];
    if ((a.y() - height_m) * (b.y() - height_m) > 0.0) continue;
    const double share = std::abs(b.y() - a.y()) > 1e-12 ? (height_m - a.y()) / (b.y() - a.y()) : 0.0;
    radius_m = std::max(radius_m, a.x() + (b.x() - a.x()) * share);
  }
  return radius_m;
}

Eigen::Vector3d Profile::turned(double t, double angle_rad) const {
  const Eigen::Vector2d p = at(t);
  return {p.x() * std::sin(angle_rad), p.y(), p.x() * std::cos(angle_rad)};
}

}  // namespace livegs::sample
