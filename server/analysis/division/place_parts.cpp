// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/division/place_parts.h"

#include <algorithm>
#include <cmath>

#include "analysis/division/label_boxes.h"

namespace livegs {
namespace {

// Wall of a part that holds another one, as fractions of its width: the first one at which at most
// kMaxWallShare of the kernels of the wall are inside. A box in a round pot needs a thick one.
constexpr double kHolderWalls[] = {0.08, 0.12, 0.16, 0.2};
constexpr double kMaxWallShare = 0.02;
// Fraction of the height of a holder below which all of its kernels are of its wall; above are a rim, and
// what is inside.
constexpr double kWallHeight = 0.75;

Eigen::AlignedBox3d label_bounds(const SurfaceKernels& kernels, std::span<const uint8_t> labels,
                                 size_t label) {
  std::vector<uint32_t> chosen;
  for (uint32_t i = 0; i < labels.size(); ++i) {
    if (labels[i] == label) chosen.push_back(i);
  }
  return bounds_without_strays({kernels.positions_m, kernels.weights, labels}, chosen);
}

// The box inside a part; empty if it has no kernels.
Eigen::AlignedBox3d room_inside(const SurfaceKernels& kernels, std::span<const uint8_t> labels,
                                const PartHolder& holder) {
  const Eigen::AlignedBox3d hull = label_bounds(kernels, labels, holder.part);
  if (hull.isEmpty()) return hull;
  const Eigen::Vector3d size = hull.sizes();
  const double wall_top = hull.min().y() + kWallHeight * size.y();
  Eigen::AlignedBox3d room;
  for (const double wall : kHolderWalls) {
    const Eigen::Vector3d across(wall * size.x(), kHolderWalls[0] * size.y(), wall * size.z());
    room = {hull.min() + across, hull.max() - across};
    if (holder.open) room.max().y() = hull.max().y();
    double whole = 0, within = 0;
    for (size_t i = 0; i < labels.size(); ++i) {
      if (labels[i] != holder.part || kernels.positions_m[i].y() > wall_top) continue;
      whole += kernels.weights[i];
      if (room.contains(kernels.positions_m[i].cast<double>())) within += kernels.weights[i];
    }
    if (within <= kMaxWallShare * whole) break;
  }
  return room;
}

// A ten-thousandth of the size is finer than any border of parts, and keeps the numbers short.
Eigen::Vector3d rounded_corner(const Eigen::Vector3d& corner_m, double size_m) {
  const double per_m = std::pow(10.0, 3 - std::floor(std::log10(size_m)));
  return (corner_m * per_m).array().round() / per_m;
}

}  // namespace

void place_parts(const SurfaceKernels& kernels, std::span<const uint8_t> labels,
                 std::span<const std::optional<PartHolder>> holder, MaterialParts& parts) {
  const size_t count = static_cast<size_t>(parts.size());
  // Enclosed parts get their boxes below. Their kernels belong to the holder while the boxes are cut.
  std::vector<uint8_t> outside(labels.begin(), labels.end());
  for (uint8_t& label : outside) {
    if (label < count && holder[label]) label = static_cast<uint8_t>(holder[label]->part);
  }
  auto boxes = label_boxes({kernels.positions_m, kernels.weights, outside}, count);
  for (size_t i = 0; i < count; ++i) {
    if (!holder[i]) continue;
    const Eigen::AlignedBox3d seen = label_bounds(kernels, labels, i);
    Eigen::AlignedBox3d hull = room_inside(kernels, outside, *holder[i]);
    if (hull.isEmpty()) continue;
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
