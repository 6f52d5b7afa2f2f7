// SPDX-License-Identifier: Apache-2.0
#include "material/part_places.h"

#include <limits>

namespace livegs {
namespace {

constexpr double kOpenSide_m = std::numeric_limits<double>::infinity();

Eigen::Vector3d box_corner(const google::protobuf::RepeatedField<double>& numbers, double open_m) {
  if (numbers.size() != 3) return Eigen::Vector3d::Constant(open_m);
  return {numbers[0], numbers[1], numbers[2]};
}

}  // namespace

Eigen::AlignedBox3d part_box(const v1::MaterialPart::Box& box) {
  return {box_corner(box.min_m(), -kOpenSide_m), box_corner(box.max_m(), kOpenSide_m)};
}

PartPlaces::PartPlaces(const MaterialParts& parts) {
  bool rest_found = false;
  for (int i = 0; i < parts.size(); ++i) {
    if (parts[i].boxes().empty() && !rest_found) rest_ = static_cast<size_t>(i), rest_found = true;
    for (const v1::MaterialPart::Box& box : parts[i].boxes()) {
      boxes_.push_back({part_box(box), static_cast<size_t>(i)});
    }
  }
}

size_t PartPlaces::at(const Eigen::Vector3d& point_m) const {
  for (auto one = boxes_.rbegin(); one != boxes_.rend(); ++one) {
    if (one->box.contains(point_m)) return one->part;
  }
  return rest_;
}

Eigen::Vector3f part_rgb(size_t part) {
  // Okabe and Ito 2008: distinct for colour-blind people too.
  constexpr float kColours[kMaxMaterialParts][3] = {
      {0.00f, 0.45f, 0.70f}, {0.90f, 0.62f, 0.00f}, {0.00f, 0.62f, 0.45f}, {0.80f, 0.47f, 0.65f},
      {0.84f, 0.37f, 0.00f}, {0.34f, 0.71f, 0.91f}, {0.94f, 0.89f, 0.26f}, {0.45f, 0.45f, 0.45f}};
  return Eigen::Vector3f(kColours[part % kMaxMaterialParts]);
}

Eigen::Vector3f shaded_part_rgb(size_t part, const Eigen::Vector3f& own_rgb) {
  return (0.5f + 0.5f * own_rgb.mean()) * part_rgb(part);
}

}  // namespace livegs
