// SPDX-License-Identifier: GPL-3.0-or-later
#include "sample/rooms/solid_kernels.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "sample/tools/noise.h"
#include "sample/tools/random.h"

namespace livegs::sample {
namespace {

using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;
// Deviations of a kernel in spacings: across the surface the sum of neighbours is opaque, along the normal it
// stays a thin sheet.
constexpr double kAcross = 0.62, kThick = 0.08;
constexpr float kKernelOpacity = 0.95f;
constexpr double kMugWall = 0.08;  // of the diameter

// Points of a patch P(u, v) in rows of equal spacing, jittered by a fifth of it.
void add_patch(const std::function<Vector3d(double, double)>& position, double spacing_m, Random& random,
               bool outward_by_u_cross_v, std::vector<SurfacePoint>& points) {
  constexpr int kSteps = 32;
  const double d = 1e-4;
  const auto length = [&](bool along_u, double other) {
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
      const double a = static_cast<double>(i) / kSteps, b = static_cast<double>(i + 1) / kSteps;
      sum += along_u ? (position(b, other) - position(a, other)).norm()
                     : (position(other, b) - position(other, a)).norm();
    }
    return sum;
  };
  const double height = std::max({length(false, 0.0), length(false, 0.5), length(false, 1.0)});
  const int rows = std::max(1, static_cast<int>(std::lround(height / spacing_m)));
  for (int row = 0; row < rows; ++row) {
    const double middle = (row + 0.5) / rows;
    const int columns = std::max(1, static_cast<int>(std::lround(length(true, middle) / spacing_m)));
    for (int column = 0; column < columns; ++column) {
      const double u = std::clamp(
          (column + 0.5 + (row % 2 ? 0.25 : -0.25) + 0.2 * random.uniform(-1, 1)) / columns, 0.0, 1.0);
      const double v = std::clamp((row + 0.5 + 0.2 * random.uniform(-1, 1)) / rows, 0.0, 1.0);
      const double u0 = std::max(0.0, u - d), u1 = std::min(1.0, u + d), v0 = std::max(0.0, v - d),
                   v1 = std::min(1.0, v + d);
      const Vector3d du = (position(u1, v) - position(u0, v)), dv = (position(u, v1) - position(u, v0));
      Vector3d normal = outward_by_u_cross_v ? du.cross(dv) : dv.cross(du);
      if (!(normal.norm() > 1e-14) || !(du.norm() > 1e-14)) continue;
      points.push_back({position(u, v), normal.normalized(), du.normalized(), spacing_m});
    }
  }
}

// A surface of revolution about y through (radius, height) for t in 0..1, outside to the right of the curve.
void add_lathe(const std::function<Eigen::Vector2d(double)>& profile, double spacing_m, Random& random,
               std::vector<SurfacePoint>& points) {
  add_patch(
      [&](double u, double v) {
        const Eigen::Vector2d at = profile(v);
        return Vector3d(at.x() * std::sin(2 * kPi * u), at.y(), at.x() * std::cos(2 * kPi * u));
      },
      spacing_m, random, true, points);
}

Eigen::Vector2d polyline(const std::vector<Eigen::Vector2d>& corners, double t) {
  double total = 0;
  for (size_t i = 1; i < corners.size(); ++i) total += (corners[i] - corners[i - 1]).norm();
  double at = t * total;
  for (size_t i = 1; i < corners.size(); ++i) {
    const double length = (corners[i] - corners[i - 1]).norm();
    if (at <= length || i + 1 == corners.size())
      return corners[i - 1] + (corners[i] - corners[i - 1]) * std::min(1.0, at / length);
    at -= length;
  }
  return corners.back();
}

std::vector<Eigen::Vector2d> bottle_profile(const Vector3d& size) {
  const double r = 0.5 * size.x(), h = size.y();
  return {{r, 0}, {r, 0.6 * h}, {0.8 * r, 0.72 * h}, {0.4 * r, 0.82 * h}, {0.4 * r, h}, {0.001, h}};
}

double rounded_cylinder(const Vector3d& p, double radius, double height) {
  const double across = std::hypot(p.x(), p.z()) - radius;
  const double along = std::abs(p.y() - 0.5 * height) - 0.5 * height;
  return std::min(std::max(across, along), 0.0) + std::hypot(std::max(across, 0.0), std::max(along, 0.0));
}

}  // namespace

Vector3d Solid::local(const Vector3d& point_m) const {
  const Vector3d d = point_m - base_m;
  const double c = std::cos(yaw_rad), s = std::sin(yaw_rad);
  return {c * d.x() - s * d.z(), d.y(), s * d.x() + c * d.z()};
}

double Solid::distance_m(const Vector3d& point_m) const {
  const Vector3d p = local(point_m);
  switch (shape) {
    case SolidShape::Box: {
      const Vector3d q = (p - Vector3d(0, 0.5 * size_m.y(), 0)).cwiseAbs() - 0.5 * size_m;
      return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
    }
    case SolidShape::Ball:
      return (p - Vector3d(0, 0.5 * size_m.y(), 0)).norm() - 0.5 * size_m.x();
    default:
      return rounded_cylinder(p, 0.5 * size_m.x(), size_m.y());
  }
}

Eigen::AlignedBox3d Solid::bounds_m() const {
  Eigen::AlignedBox3d box;
  const double c = std::abs(std::cos(yaw_rad)), s = std::abs(std::sin(yaw_rad));
  const bool turned = shape == SolidShape::Box;
  const double x = turned ? c * size_m.x() + s * size_m.z() : size_m.x();
  const double z = turned ? s * size_m.x() + c * size_m.z() : size_m.z();
  box.extend(base_m + Vector3d(-0.5 * x, 0, -0.5 * z));
  box.extend(base_m + Vector3d(0.5 * x, size_m.y(), 0.5 * z));
  return box;
}

Vector3d Solid::colour_at(const SurfacePoint& point, uint64_t seed) const {
  const Vector3d p = local(point.position_m);
  Vector3d colour = rgb * (1 + 0.06 * fractal_noise(p / 0.015, 2, seed));
  const double height = p.y() / size_m.y();
  if (pattern == 1 && height > 0.3 && height < 0.75 && std::abs(p.x()) < 0.35 * size_m.x())
    colour = Vector3d(0.88, 0.86, 0.8) - 0.25 * rgb;
  if (pattern == 2 && std::fmod(height * 4, 1.0) < 0.35) colour = Vector3d::Constant(0.9) - 0.5 * rgb;
  return colour;
}

std::vector<SurfacePoint> rectangle_points(const Vector3d& corner_m, const Vector3d& along_m,
                                           const Vector3d& across_m, double spacing_m, uint64_t seed) {
  Random random(seed);
  std::vector<SurfacePoint> points;
  add_patch([&](double u, double v) { return Vector3d(corner_m + u * along_m + v * across_m); }, spacing_m,
            random, true, points);
  return points;
}

std::vector<SurfacePoint> solid_points(const Solid& solid, double spacing_m, uint64_t seed) {
  Random random(seed);
  std::vector<SurfacePoint> points;
  const Vector3d size = solid.size_m;
  const double r = 0.5 * size.x(), h = size.y();
  const auto lathe = [&](const std::vector<Eigen::Vector2d>& corners) {
    for (size_t i = 1; i < corners.size(); ++i)
      add_lathe(
          [&](double t) {
            return polyline({corners[i - 1], corners[i]}, t);
          },
          spacing_m, random, points);
  };
  switch (solid.shape) {
    case SolidShape::Box: {
      const Vector3d low(-0.5 * size.x(), 0, -0.5 * size.z());
      const Vector3d x(size.x(), 0, 0), y(0, size.y(), 0), z(0, 0, size.z());
      const auto face = [&](const Vector3d& corner, const Vector3d& along, const Vector3d& across) {
        add_patch([&](double u, double v) { return Vector3d(corner + u * along + v * across); }, spacing_m,
                  random, true, points);
      };
      face(low + y, z, x);
      face(low + z, x, y);
      face(low, y, x);
      face(low, z, y);
      face(low + x, y, z);
      break;
    }
    case SolidShape::Ball:
      add_lathe(
          [&](double t) {
            const double angle = kPi * (t - 0.5);
            return Eigen::Vector2d(r * std::cos(angle), r + r * std::sin(angle));
          },
          spacing_m, random, points);
      break;
    case SolidShape::Cylinder:
      lathe({{r, 0}, {r, h}, {0.001, h}});
      break;
    case SolidShape::Bottle:
      lathe(bottle_profile(size));
      break;
    case SolidShape::Mug: {
      const double inner = r - kMugWall * size.x();
      lathe({{r, 0}, {r, h}, {inner, h}, {inner, 0.08 * h}, {0.001, 0.08 * h}});
      const double thick = 0.06 * size.x();
      add_patch(
          [&](double u, double v) {
            const double angle = kPi * (u - 0.5), around = 2 * kPi * v;
            const double ring = 0.3 * h + thick * std::cos(around);
            return Vector3d(r + 0.85 * ring * std::cos(angle), 0.5 * h + ring * std::sin(angle),
                            thick * std::sin(around));
          },
          0.8 * spacing_m, random, false, points);
      break;
    }
  }
  const double c = std::cos(solid.yaw_rad), s = std::sin(solid.yaw_rad);
  const auto turn = [&](const Vector3d& p) {
    return Vector3d(c * p.x() + s * p.z(), p.y(), -s * p.x() + c * p.z());
  };
  for (SurfacePoint& point : points) {
    point.position_m = turn(point.position_m) + solid.base_m;
    point.normal = turn(point.normal);
    point.tangent = turn(point.tangent);
  }
  return points;
}

void SolidKernels::add(const SurfacePoint& point, const Vector3d& rgb, size_t owner_number) {
  const Vector3d light = Vector3d(0.45, 0.8, 0.4).normalized();
  const double shade = 0.55 + 0.45 * std::max(0.0, point.normal.dot(light));
  const Vector3d seen = (shade * rgb).cwiseMin(1.0).cwiseMax(0.0);
  // Modelling frame to asset frame: a half turn about x.
  const auto flip = [](const Vector3d& p) { return Vector3d(p.x(), -p.y(), -p.z()); };
  Eigen::Matrix3d axes;
  axes.col(0) = flip(point.tangent);
  axes.col(2) = flip(point.normal);
  axes.col(1) = axes.col(2).cross(axes.col(0));
  asset.positions.push_back(flip(point.position_m).cast<float>());
  asset.rotations.push_back(Eigen::Quaterniond(axes).normalized().cast<float>());
  const float across = static_cast<float>(std::log(kAcross * point.spacing_m));
  asset.log_scales.push_back({across, across, static_cast<float>(std::log(kThick * point.spacing_m))});
  asset.opacity_logits.push_back(std::log(kKernelOpacity / (1 - kKernelOpacity)));
  asset.sh_dc.push_back(((seen.array() - 0.5) / kShBand0).matrix().cast<float>());
  owner.push_back(static_cast<uint16_t>(owner_number));
}

}  // namespace livegs::sample
