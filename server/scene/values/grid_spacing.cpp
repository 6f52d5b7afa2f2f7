// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/values/grid_spacing.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>

namespace livegs {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kMinStep = 0.9, kMaxStep = 1.8;  // search range, relative to the median nearest distance
// The first estimate uses points within this many steps of the middle, and at least kFirstPointCount points.
constexpr double kFirstReachSteps = 12.0;
constexpr Eigen::Index kFirstPointCount = 64;
constexpr size_t kMaxRefinedPoints = 20000;  // points used to refine the step
// Minimum side relative to the nearest distance; no grid can be detected along a shorter side.
constexpr double kMinSideRatio = 2.5;
// Minimum structure factor, and its minimum ratio to that of the same number of random points.
constexpr double kMinStructureFactor = 0.12, kMinNoiseRatio = 8.0;

// Returns the mean over the axes of |mean exp(2 pi i x / step)|², where x is a column.
double structure_factor(const Eigen::MatrixX3d& columns, const std::vector<int>& axes, double step_m) {
  double sum = 0.0;
  for (const int axis : axes) {
    const Eigen::ArrayXd phase = columns.col(axis).array() * (2.0 * M_PI / step_m);
    sum += std::norm(std::complex<double>(phase.cos().mean(), phase.sin().mean()));
  }
  return sum / static_cast<double>(axes.size());
}

// Refines the step by least squares of each coordinate against its nearest multiple of the step. The peak
// alone is biased towards longer steps, for which the deviations are relatively smaller.
double fitted_step(const Eigen::MatrixX3d& columns, const std::vector<int>& axes, double step_m) {
  double both = 0.0, whole = 0.0;
  for (const int axis : axes) {
    const Eigen::ArrayXd phase = columns.col(axis).array() * (2.0 * M_PI / step_m);
    const double offset = std::atan2(phase.sin().mean(), phase.cos().mean());
    const Eigen::ArrayXd steps = ((phase - offset) / (2.0 * M_PI)).round(), deviations = steps - steps.mean();
    both += (deviations * columns.col(axis).array()).sum();
    whole += (deviations * deviations).sum();
  }
  return whole > 0.0 ? both / whole : step_m;
}

struct Found {
  double step_m = 0.0, factor = 0.0;
};

// Searches the rows of `along`, sorted by distance from the middle.
Found look_along(const Eigen::MatrixX3d& along, const Eigen::VectorXd& distances_m, double nearest_m) {
  const auto within = [&](double reach_m) {
    return std::upper_bound(distances_m.begin(), distances_m.end(), reach_m) - distances_m.begin();
  };
  double low = kMinStep * nearest_m, high = kMaxStep * nearest_m;
  Found best;
  const double first_m = distances_m[std::min(kFirstPointCount, distances_m.size() - 1)];
  for (double reach = std::max(first_m, kFirstReachSteps * nearest_m);; reach *= 2.0) {
    const Eigen::Index count = std::min<Eigen::Index>(within(reach), kMaxRefinedPoints);
    const Eigen::MatrixX3d part = along.topRows(count);
    std::vector<int> axes;
    double longest = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      const double size = part.col(axis).maxCoeff() - part.col(axis).minCoeff();
      if (size > kMinSideRatio * nearest_m) axes.push_back(axis);
      longest = std::max(longest, size);
    }
    if (axes.empty()) return {};
    // A peak has a width of step² / size.
    best = {};
    for (double step = low; step <= high; step += 0.1 * step * step / longest) {
      const double factor = structure_factor(part, axes, step);
      if (factor > best.factor) best = {step, factor};
    }
    if (best.step_m == 0.0) return {};
    const double least = std::max(kMinStructureFactor, kMinNoiseRatio / static_cast<double>(count));
    if (best.factor < least) return {};
    // Refines the peak by a parabola through three samples, a tenth of the scan range apart.
    const double d = 0.1 * best.step_m * best.step_m / longest;
    const double before = structure_factor(part, axes, best.step_m - d),
                 after = structure_factor(part, axes, best.step_m + d);
    const double bend = before - 2.0 * best.factor + after;
    if (bend < 0.0) best.step_m += std::clamp(0.5 * d * (before - after) / bend, -d, d);
    if (count == along.rows() || count == static_cast<Eigen::Index>(kMaxRefinedPoints)) {
      return {fitted_step(part, axes, best.step_m), best.factor};
    }
    low = best.step_m - 2.0 * d;
    high = best.step_m + 2.0 * d;
  }
}

}  // namespace

double grid_spacing_m(const std::vector<Vector3d>& points_m, double nearest_m) {
  if (points_m.size() < 8 || !(nearest_m > 0.0)) return 0.0;
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& point : points_m) mean += point / static_cast<double>(points_m.size());
  Matrix3d spread = Matrix3d::Zero();
  for (const Vector3d& point : points_m) spread += (point - mean) * (point - mean).transpose();
  // A hollow list has no point at its middle; the nearest point is used.
  const Vector3d centre =
      *std::min_element(points_m.begin(), points_m.end(), [&](const Vector3d& a, const Vector3d& b) {
        return (a - mean).squaredNorm() < (b - mean).squaredNorm();
      });
  std::vector<std::pair<double, uint32_t>> order;
  for (uint32_t i = 0; i < points_m.size(); ++i) order.push_back({(points_m[i] - centre).norm(), i});
  std::sort(order.begin(), order.end());
  Eigen::MatrixX3d sorted(static_cast<Eigen::Index>(order.size()), 3);
  Eigen::VectorXd distances(sorted.rows());
  for (Eigen::Index i = 0; i < sorted.rows(); ++i) {
    distances[i] = order[static_cast<size_t>(i)].first;
    sorted.row(i) = (points_m[order[static_cast<size_t>(i)].second] - centre).transpose();
  }
  const Matrix3d own = Eigen::SelfAdjointEigenSolver<Matrix3d>(spread).eigenvectors();
  const Found in_world = look_along(sorted, distances, nearest_m),
              in_own = look_along(sorted * own, distances, nearest_m);
  return in_own.factor > in_world.factor ? in_own.step_m : in_world.step_m;
}

}  // namespace livegs
