// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/values/points_file.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "geometry/mesh/mesh_topology.h"
#include "scene/values/csv_lines.h"
#include "scene/values/grid_spacing.h"

namespace livegs {
namespace {

constexpr double kMaxMagnitude = 1e6;  // metres or metres per second
constexpr uint64_t kMaxPointsFileBytes = 256 << 20;

}  // namespace

Result<PointList> read_points_file(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  PointList list;
  const CsvLayout layout{"x,y,z", "x,y,z,vx,vy,vz", kMaxMagnitude, kMaxPointsFileBytes};
  const auto take = [&](size_t, std::span<const double> numbers) -> Result<void> {
    if (list.positions_m.size() == kMaxPoints) {
      return Error{ErrorCode::TooLarge,
                   name + ": has more than " + std::to_string(kMaxPoints) + " points; give fewer"};
    }
    list.positions_m.emplace_back(numbers[0], numbers[1], numbers[2]);
    if (numbers.size() == 6) list.velocities_m_s.emplace_back(numbers[3], numbers[4], numbers[5]);
    return {};
  };
  if (auto read = read_csv_lines(path, layout, take); !read) return read.error();
  if (list.positions_m.empty()) return invalid_data(name + ": contains no points; give at least one");
  return list;
}

namespace {

// Returns the distances to the nearest other point for a sample of the points, sorted.
std::vector<double> nearest_distances_m(const std::vector<Eigen::Vector3d>& points_m) {
  const size_t count = points_m.size();
  if (count < 2) return {};
  // With points sorted by x, the search goes both ways until the distance in x alone is larger.
  std::vector<uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    return points_m[a].x() != points_m[b].x() ? points_m[a].x() < points_m[b].x() : a < b;
  });
  constexpr size_t kSamples = 1001;  // samples every stride-th point
  const size_t stride = std::max<size_t>(1, count / kSamples);
  std::vector<double> nearest;
  for (size_t i = 0; i < count; i += stride) {
    const Eigen::Vector3d& point = points_m[order[i]];
    double best = std::numeric_limits<double>::infinity();
    for (size_t j = i; j-- > 0;) {
      if (point.x() - points_m[order[j]].x() >= best) break;
      best = std::min(best, (points_m[order[j]] - point).norm());
    }
    for (size_t j = i + 1; j < count; ++j) {
      if (points_m[order[j]].x() - point.x() >= best) break;
      best = std::min(best, (points_m[order[j]] - point).norm());
    }
    nearest.push_back(best);
  }
  std::sort(nearest.begin(), nearest.end());
  return nearest;
}

}  // namespace

double median_spacing_m(const std::vector<Eigen::Vector3d>& points_m) {
  const std::vector<double> nearest = nearest_distances_m(points_m);
  return nearest.empty() ? 0.0 : nearest[nearest.size() / 2];
}

double filling_spacing_m(const std::vector<Eigen::Vector3d>& points_m,
                         const TriangleMesh& through_outermost) {
  const std::vector<double> nearest = nearest_distances_m(points_m);
  if (nearest.empty()) return 0.0;
  const double median = nearest[nearest.size() / 2];
  // Relative to the median, between the 10th and 90th percentile.
  constexpr double kMaxRegularDeviation = 0.02;
  if (nearest[nearest.size() * 9 / 10] - nearest[nearest.size() / 10] < kMaxRegularDeviation * median)
    return median;
  if (const double step = grid_spacing_m(points_m, median); step > 0.0) return step;

  // The mesh passes through the outermost points, half a spacing inside the body. A box or an ellipsoid that
  // grows by g on every side grows by (1 + 2 g / size) along each axis. Jitter moves the mesh outwards,
  // because points that moved inwards lie behind it. The outward bias is kBiasRatio of the amount by which
  // the nearest neighbours are closer than kMaxStraying spacings. Both values are fitted to jittered blocks.
  constexpr double kMaxStraying = 0.9, kBiasRatio = 0.65;
  const double volume_m3 = signed_volume_m3(through_outermost);
  const Eigen::Array3d size_m = mesh_bounds_m(through_outermost).sizes().array();
  if (!(volume_m3 > 0.0) || !(size_m > 0.0).all()) return median;
  double spacing = median;
  for (int i = 0; i < 50; ++i) {
    const double growth_m = 0.5 * spacing - kBiasRatio * std::max(0.0, kMaxStraying * spacing - median);
    spacing =
        std::cbrt(volume_m3 * (1.0 + 2.0 * growth_m / size_m).prod() / static_cast<double>(points_m.size()));
  }
  return spacing;
}

}  // namespace livegs
