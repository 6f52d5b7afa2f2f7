// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

namespace livegs {

// Points with a label each; points with kNoLabel are ignored.
inline constexpr uint8_t kNoLabel = 255;
struct LabelledPoints {
  std::span<const Eigen::Vector3f> positions_m;
  std::span<const float> weights;
  std::span<const uint8_t> labels;  // 0 … label_count - 1
};

// Bounds of some of the points without the outermost 2 % of their weight on each side; empty without weight.
Eigen::AlignedBox3d bounds_without_strays(const LabelledPoints& points, std::span<const uint32_t> chosen);

// Boxes that separate the labels: the leaves of a decision tree with axis-parallel cuts (Breiman et al. 1984,
// CART), each as far as its own points reach. The label with the most leaves, or the largest of as many, has
// no boxes: it has the remaining volume. Boxes of different labels do not overlap. At most 12 in all; a label
// without points has none. Deterministic.
std::vector<std::vector<Eigen::AlignedBox3d>> label_boxes(const LabelledPoints& points, size_t label_count);

}  // namespace livegs
