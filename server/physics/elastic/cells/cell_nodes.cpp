// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/elastic/cells/cell_nodes.h"

#include <algorithm>
#include <cmath>

namespace livegs {

CellNodes::CellNodes(size_t count, double cell_width_m) : count_(count) {
  const size_t padded = (count + 8 + 1) / 2 * 2;
  const Node nothing{NodeLanes{0, 0, 0, 0}};
  for (auto* array : {&position_, &predicted_, &velocity_, &predicted_velocity_, &corrections_}) {
    array->assign(padded, nothing);
  }
  for (size_t c = 0; c < 8; ++c) {
    const Eigen::Vector3d corner(c & 1 ? 0.5 : -0.5, c & 2 ? 0.5 : -0.5, c & 4 ? 0.5 : -0.5);
    set_motion(count + c, cell_width_m * corner, Eigen::Vector3d::Zero());
  }
}

void CellNodes::set_mass(size_t node, double mass_kg, double inverse_mass) {
  position_[node].value[3] = predicted_[node].value[3] = static_cast<float>(inverse_mass);
  velocity_[node].value[3] = predicted_velocity_[node].value[3] = static_cast<float>(mass_kg);
}

void CellNodes::set_motion(size_t node, const Eigen::Vector3d& position_m,
                           const Eigen::Vector3d& velocity_m_s) {
  set(position_[node], position_m);
  set(predicted_[node], position_m);
  set(velocity_[node], velocity_m_s);
  set(predicted_velocity_[node], velocity_m_s);
}

AnchorNodes CellNodes::anchor_nodes(const NodeSample& sample, double step_s) {
  AnchorNodes anchor;
  anchor.corrections = reinterpret_cast<float*>(corrections_.data());
  for (int c = 0; c < 8; ++c)
    anchor.pulls[c] = static_cast<float>(step_s) * sample.weights[c] * predicted_[sample.nodes[c]].value[3];
  anchor.base_m = mean(sample, [&](uint32_t node) { return predicted_[node].value - position_[node].value; });
  return anchor;
}

void CellNodes::predict(size_t node, const Eigen::Vector3d& position_m, const Eigen::Vector3d& velocity_m_s) {
  set(predicted_[node], position_m);
  set(predicted_velocity_[node], velocity_m_s);
}

void CellNodes::push(size_t node, const Eigen::Vector3d& displacement_m,
                     const Eigen::Vector3d& velocity_m_s) {
  add(predicted_[node], displacement_m);
  add(predicted_velocity_[node], velocity_m_s);
}

double CellNodes::move_all(const Eigen::Vector3d& by_m, const Eigen::Vector3d& centre_m) {
  NodeArrays all = arrays();
  all.count = count_ / 2 * 2;
  double furthest =
      all.count > 0 ? std::sqrt(static_cast<double>(shift_nodes(all, lanes(by_m), lanes(centre_m)))) : 0.0;
  for (size_t i = all.count; i < count_; ++i) {
    add(position_[i], by_m);
    add(predicted_[i], by_m);
    furthest = std::max(furthest, (position_m(i) - centre_m).norm());
  }
  return furthest;
}

std::array<NodeLanes, 8> CellNodes::corners_m(const std::array<uint32_t, 8>& nodes,
                                              const Eigen::AlignedBox3f& local, bool corrected) const {
  std::array<NodeLanes, 8> corners;
  for (int c = 0; c < 8; ++c) corners[c] = place_m(nodes[c], corrected);
  for (int axis = 0; axis < 3; ++axis) {
    const float low = 0.5f + 0.5f * local.min()[axis], high = 0.5f + 0.5f * local.max()[axis];
    for (int c = 0; c < 8; ++c) {
      const int d = c | 1 << axis;
      if (c == d) continue;
      const NodeLanes from = corners[c], way = corners[d] - corners[c];
      corners[c] = from + low * way;
      corners[d] = from + high * way;
    }
  }
  return corners;
}

void CellNodes::stop() {
  for (size_t i = 0; i < count_; ++i) set_motion(i, position_m(i), Eigen::Vector3d::Zero());
}

NodeArrays CellNodes::arrays() {
  return {position_.size(),    &position_[0].value,           &predicted_[0].value,
          &velocity_[0].value, &predicted_velocity_[0].value, &corrections_[0].value};
}

}  // namespace livegs
