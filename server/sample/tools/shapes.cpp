// SPDX-License-Identifier: GPL-3.0-or-later
#include "sample/tools/shapes.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace livegs::sample {

using Eigen::Vector3d;

namespace {
constexpr double kTurn = 6.283185307179586;
}

ParametricSurface lathe(Profile profile, double spacing_m, int part) {
  ParametricSurface surface;
  surface.position_m = [profile = std::move(profile)](double u, double v) { return profile.turned(v, u); };
  surface.u_max = kTurn;
  surface.cells_u = 64;
  surface.cells_v = 192;
  surface.spacing_m = spacing_m;
  surface.part = part;
  return surface;
}

ParametricSurface sweep(std::function<Vector3d(double)> curve, const Vector3d& reference,
                        std::function<Eigen::Vector2d(double)> half_axes_m, double spacing_m, int part) {
  ParametricSurface surface;
  surface.position_m = [curve = std::move(curve), reference, half_axes_m = std::move(half_axes_m)](double u,
                                                                                                   double v) {
    constexpr double kStep = 1e-3;
    const Vector3d centre = curve(u);
    const Vector3d along = (curve(std::min(1.0, u + kStep)) - curve(std::max(0.0, u - kStep))).normalized();
    const Vector3d first = (reference - along * along.dot(reference)).normalized();
    const Vector3d second = along.cross(first);
    const Eigen::Vector2d half = half_axes_m(u);
    return Vector3d(centre + half.x() * std::cos(v) * first - half.y() * std::sin(v) * second);
  };
  surface.v_max = kTurn;
  surface.cells_u = 96;
  surface.cells_v = 32;
  surface.spacing_m = spacing_m;
  surface.part = part;
  return surface;
}

std::function<Vector3d(double)> curve_through(std::vector<Vector3d> points_m) {
  return [points = std::move(points_m)](double u) {
    const int spans = static_cast<int>(points.size()) - 1;
    const double place = std::clamp(u, 0.0, 1.0) * spans;
    const int i = std::min(static_cast<int>(place), spans - 1);
    const double t = place - i;
    const Vector3d &b = points[i], &c = points[i + 1];
    const Vector3d a = i > 0 ? points[i - 1] : Vector3d(2 * b - c);
    const Vector3d d = i + 2 <= spans ? points[i + 2] : Vector3d(2 * c - b);
    return Vector3d(0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t * t +
                           (3 * b - a - 3 * c + d) * t * t * t));
  };
}

void stand_at_origin(GaussianAsset& asset) {
  if (asset.positions.empty()) return;
  Eigen::Vector3f low = asset.positions.front(), high = low;
  for (const Eigen::Vector3f& p : asset.positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Eigen::Vector3f shift(0.5f * (low.x() + high.x()), high.y(), 0.5f * (low.z() + high.z()));
  for (Eigen::Vector3f& p : asset.positions) p -= shift;
}

}  // namespace livegs::sample
