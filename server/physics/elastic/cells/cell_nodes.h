// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "physics/elastic/cells/kernels/node_kernels.h"
#include "physics/elastic/contact_constraints.h"

// The nodes of a body's lattice in single precision, relative to an origin that follows the body, so that
// precision does not depend on the position in the world.

namespace livegs {

class CellNodes {
 public:
  CellNodes() = default;
  // `count` nodes, followed by eight spare nodes at the corners of a cell of width `cell_width_m`.
  CellNodes(size_t count, double cell_width_m);

  static NodeLanes lanes(const Eigen::Vector3d& v) {
    return NodeLanes{static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()), 0.0f};
  }
  size_t count() const { return count_; }
  uint32_t spare() const { return static_cast<uint32_t>(count_); }

  // Inverse mass 0: the node is held.
  void set_mass(size_t node, double mass_kg, double inverse_mass);

  Eigen::Vector3d position_m(size_t node) const { return vector(position_[node]); }
  Eigen::Vector3d velocity_m_s(size_t node) const { return vector(velocity_[node]); }
  // Sets the current and the previous state.
  void set_motion(size_t node, const Eigen::Vector3d& position_m, const Eigen::Vector3d& velocity_m_s);

  // Between predict and advance: position of a material point, before and after the corrections so far.
  Eigen::Vector3d position_m(const NodeSample& sample) const {
    return mean(sample, [&](uint32_t node) { return position_[node].value; });
  }
  Eigen::Vector3d corrected_m(const NodeSample& sample) const {
    return mean(sample, [&](uint32_t node) { return predicted_[node].value + corrections_[node].value; });
  }
  Eigen::Vector3d displacement_m(const NodeSample& sample) const {  // corrected_m - position_m
    return mean(sample, [&](uint32_t node) {
      return predicted_[node].value - position_[node].value + corrections_[node].value;
    });
  }
  // Corners of a box within a cell (local coordinates -1 ... 1) after deformation. Every point of the
  // deformed box is a mean of these eight.
  std::array<NodeLanes, 8> corners_m(const std::array<uint32_t, 8>& nodes, const Eigen::AlignedBox3f& local,
                                     bool corrected) const;
  NodeLanes place_m(uint32_t node, bool corrected) const {
    return corrected ? predicted_[node].value + corrections_[node].value : position_[node].value;
  }
  Eigen::Vector3d corrected_m(size_t node) const {
    return vector(predicted_[node]) + vector(corrections_[node]);
  }
  void correct(size_t node, const Eigen::Vector3d& by_m) { add(corrections_[node], by_m); }
  // Applies an impulse times h_e at a material point.
  void pull(const NodeSample& sample, const Eigen::Vector3d& pull_kg_m) {
    const NodeLanes by = lanes(pull_kg_m);
#pragma GCC unroll 8
    for (int c = 0; c < 8; ++c) {
      const uint32_t node = sample.nodes[c];
      corrections_[node].value += sample.weights[c] * predicted_[node].value[3] * by;
    }
  }
  // A material point whose displacement follows the corrections; impulses act during `step_s`.
  AnchorNodes anchor_nodes(const NodeSample& sample, double step_s);
  void predict(size_t node, const Eigen::Vector3d& position_m, const Eigen::Vector3d& velocity_m_s);
  void push(size_t node, const Eigen::Vector3d& displacement_m, const Eigen::Vector3d& velocity_m_s);
  // After advance: an impulse at a material point, added to the velocity before the step.
  void push_before(const NodeSample& sample, const Eigen::Vector3d& impulse_n_s) {
    const NodeLanes by = lanes(impulse_n_s);
#pragma GCC unroll 8
    for (int c = 0; c < 8; ++c) {
      const uint32_t node = sample.nodes[c];
      predicted_velocity_[node].value += sample.weights[c] * position_[node].value[3] * by;
    }
  }

  // Between steps: changes the velocity and the previous velocity.
  void change_velocities(size_t node, const Eigen::Vector3d& by_m_s) {
    add(velocity_[node], by_m_s);
    add(predicted_velocity_[node], by_m_s);
  }

  // Moves current and previous positions. Returns the largest distance from `centre_m` afterwards.
  double move_all(const Eigen::Vector3d& by_m, const Eigen::Vector3d& centre_m);
  void stop();  // zeroes the current and the previous velocity

  NodeArrays arrays();
  const NodeLanes* positions() const { return &position_[0].value; }
  const NodeLanes* predicted() const { return &predicted_[0].value; }
  NodeLanes* corrections() { return &corrections_[0].value; }
  void swap() {  // after advance
    position_.swap(predicted_);
    velocity_.swap(predicted_velocity_);
  }
  size_t bytes() const { return 5 * position_.capacity() * sizeof(Node); }

 private:
  struct alignas(16) Node {
    NodeLanes value;
  };
  template <class Value>
  static Eigen::Vector3d mean(const NodeSample& sample, const Value& value) {
    NodeLanes low{0, 0, 0, 0}, high{0, 0, 0, 0};  // two sums, to break the dependency chain
#pragma GCC unroll 4
    for (int c = 0; c < 4; ++c) {
      low += sample.weights[c] * value(sample.nodes[c]);
      high += sample.weights[c + 4] * value(sample.nodes[c + 4]);
    }
    low += high;
    return {low[0], low[1], low[2]};
  }
  static Eigen::Vector3d vector(const Node& n) { return {n.value[0], n.value[1], n.value[2]}; }
  static void set(Node& n, const Eigen::Vector3d& v) {
    n.value = NodeLanes{static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()),
                        n.value[3]};
  }
  static void add(Node& n, const Eigen::Vector3d& v) { n.value += lanes(v); }

  size_t count_ = 0;
  // Layout as NodeArrays between steps: w is the inverse mass of positions and the mass of velocities.
  std::vector<Node> position_, predicted_, velocity_, predicted_velocity_, corrections_;
};

}  // namespace livegs
