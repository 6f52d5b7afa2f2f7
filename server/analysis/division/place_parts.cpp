// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/division/place_parts.h"

#include <algorithm>
#include <cmath>

#include "analysis/division/label_boxes.h"

namespace livegs {
namespace {

// Wall of a part that holds another one, as a fraction of its width: pots, shades. Larger: less is inside.
constexpr double kHolderWall = 0.08;
// Share of the weight of a part beyond the bounds on each side: stray kernels.
constexpr double kStrayShare = 0.02;

double quantile_of(std::vector<std::pair<float, float>>& places, double share) {
  std::sort(places.begin(), places.end());
  double sum = 0, reached = 0;
  for (const auto& [place, weight] : places) sum += weight;
  for (const auto& [place, weight] : places) {
    reached += weight;
    if (reached >= share * sum) return place;
  }
  return places.empty() ? 0 : places.back().first;
}

// Bounds of the kernels with one label, without strays; empty if there are none.
Eigen::AlignedBox3d label_bounds(const SurfaceKernels& kernels, std::span<const uint8_t> labels,
                                 size_t label) {
  Eigen::Vector3d low, high;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<std::pair<float, float>> places;
    for (size_t i = 0; i < labels.size(); ++i) {
      if (labels[i] == label) places.emplace_back(kernels.positions_m[i][axis], kernels.weights[i]);
    }
    if (places.empty()) return {};
    low[axis] = quantile_of(places, kStrayShare);
    high[axis] = quantile_of(places, 1 - kStrayShare);
  }
  return {low, high};
}

// A ten-thousandth of the size is finer than any border of parts, and keeps the numbers short.
Eigen::Vector3d rounded_corner(const Eigen::Vector3d& corner_m, double size_m) {
  const double per_m = std::pow(10.0, 3 - std::floor(std::log10(size_m)));
  return (corner_m * per_m).array().round() / per_m;
}

}  // namespace

void place_parts(const SurfaceKernels& kernels, std::span<const uint8_t> labels,
                 std::span<const std::optional<size_t>> holder, MaterialParts& parts) {
  const size_t count = static_cast<size_t>(parts.size());
  // What is enclosed gets its own box below; its kernels belong to the holder while the boxes are cut.
  std::vector<uint8_t> outside(labels.begin(), labels.end());
  for (uint8_t& label : outside) {
    if (label < count && holder[label]) label = static_cast<uint8_t>(*holder[label]);
  }
  auto boxes = label_boxes({kernels.positions_m, kernels.weights, outside}, count);
  for (size_t i = 0; i < count; ++i) {
    if (!holder[i]) continue;
    Eigen::AlignedBox3d hull = label_bounds(kernels, outside, *holder[i]);
    if (hull.isEmpty()) continue;
    const Eigen::AlignedBox3d seen = label_bounds(kernels, labels, i);
    const Eigen::Vector3d size = hull.sizes();
    hull.min() += kHolderWall * size;
    hull.max() -= Eigen::Vector3d(kHolderWall * size.x(), 0, kHolderWall * size.z());
    if (!seen.isEmpty() && seen.max().y() > hull.min().y()) hull.max().y() = seen.max().y();
    boxes[i] = {hull};
  }
  Eigen::AlignedBox3d all;
  for (const Eigen::Vector3f& at : kernels.positions_m) all.extend(at.cast<double>());
  const double size_m = all.isEmpty() ? 1.0 : std::max(all.sizes().maxCoeff(), 1e-6);
  for (size_t i = 0; i < count; ++i) {
    for (Eigen::AlignedBox3d& box : boxes[i])
      box = {rounded_corner(box.min(), size_m), rounded_corner(box.max(), size_m)};
    set_boxes(boxes[i], *parts.Mutable(static_cast<int>(i)));
  }
}

}  // namespace livegs
