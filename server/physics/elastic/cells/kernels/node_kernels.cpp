// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/elastic/cells/kernels/node_kernels.h"

namespace livegs {
namespace {

LIVEGS_INLINE void flush(double (&sum)[3], Lanes& part) {
  for (int d = 0; d < 3; ++d) sum[d] += static_cast<double>(part[d]) + static_cast<double>(part[d + 4]);
  part = all_lanes(0.0f);
}

LIVEGS_INLINE Lanes twice(NodeLanes a) { return pair_of(a, a); }

}  // namespace

void predict_nodes(const NodeArrays& nodes, const PredictStep& step) {
  const Lanes memory = all_lanes(step.memory), kept = all_lanes(step.kept), step_s = all_lanes(step.step_s);
  const Lanes centre = twice(step.centre), correction = twice(step.correction),
              correction_spin = twice(step.correction_spin);
  const Lanes bias = twice(step.bias), spin = twice(step.spin), zero = all_lanes(0.0f);
  const Lanes field_x = twice(step.field[0]), field_y = twice(step.field[1]), field_z = twice(step.field[2]);
  typedef int Mask __attribute__((vector_size(32)));
  const Mask xyz = {-1, -1, -1, 0, -1, -1, -1, 0};
  for (size_t i = 0; i < nodes.count; i += 2) {
    const Lanes x = pair_of(nodes.position[i], nodes.position[i + 1]);
    const Lanes x_before = pair_of(nodes.predicted[i], nodes.predicted[i + 1]);
    Lanes v = pair_of(nodes.velocity[i], nodes.velocity[i + 1]);
    const Lanes v_before = pair_of(nodes.predicted_velocity[i], nodes.predicted_velocity[i + 1]);
    const Lanes r = x - centre;
    const Lanes inverse_mass = __builtin_shufflevector(x, x, 3, 3, 3, 3, 7, 7, 7, 7);
    const Mask free = (inverse_mass > zero) & xyz;
    v += free ? correction + cross_pairs(correction_spin, r) : zero;
    // w holds the mass and stays unchanged.
    const Lanes r_x = __builtin_shufflevector(r, r, 0, 0, 0, 0, 4, 4, 4, 4),
                r_y = __builtin_shufflevector(r, r, 1, 1, 1, 1, 5, 5, 5, 5),
                r_z = __builtin_shufflevector(r, r, 2, 2, 2, 2, 6, 6, 6, 6);
    const Lanes carried = kept * (v + memory * (v - v_before)) + bias + cross_pairs(spin, r) +
                          (field_x * r_x + field_y * r_y + field_z * r_z);
    const Lanes predicted = free ? carried : zero;
    const Lanes y = x + (free ? memory * (x - x_before) + step_s * predicted : zero);
    const Lanes out = xyz ? predicted : v;
    nodes.velocity[i] = low_half(v);
    nodes.velocity[i + 1] = high_half(v);
    nodes.predicted_velocity[i] = low_half(out);
    nodes.predicted_velocity[i + 1] = high_half(out);
    nodes.predicted[i] = low_half(y);
    nodes.predicted[i + 1] = high_half(y);
    nodes.corrections[i] = low_half(zero);
    nodes.corrections[i + 1] = low_half(zero);
  }
}

float shift_nodes(const NodeArrays& nodes, NodeLanes by, NodeLanes centre) {
  const Lanes both = twice(by), middle = twice(centre);
  Lanes furthest = all_lanes(0.0f);
  for (size_t i = 0; i < nodes.count; i += 2) {
    const Lanes x = pair_of(nodes.position[i], nodes.position[i + 1]) + both;
    const Lanes before = pair_of(nodes.predicted[i], nodes.predicted[i + 1]) + both;
    nodes.position[i] = low_half(x);
    nodes.position[i + 1] = high_half(x);
    nodes.predicted[i] = low_half(before);
    nodes.predicted[i + 1] = high_half(before);
    const Lanes r = x - middle, square = r * r;
    const Lanes sum = square + __builtin_shufflevector(square, square, 1, 2, 0, 3, 5, 6, 4, 7) +
                      __builtin_shufflevector(square, square, 2, 0, 1, 3, 6, 4, 5, 7);
    furthest = sum > furthest ? sum : furthest;
  }
  return furthest[0] > furthest[4] ? furthest[0] : furthest[4];
}

void advance_nodes(const NodeArrays& nodes, float step_s, NodeSums& sums) {
  const Lanes rate = all_lanes(1.0f / step_s), zero = all_lanes(0.0f);
  constexpr size_t kBlock = 32;  // nodes summed in single precision before the addition to the double sums
  sums = NodeSums{};
  for (size_t begin = 0; begin < nodes.count; begin += kBlock) {
    const size_t end = begin + kBlock < nodes.count ? begin + kBlock : nodes.count;
    Lanes mass_position = zero, momentum = zero, angular = zero, before = zero, squares = zero,
          products = zero;
    Lanes kinetic = zero;
    for (size_t i = begin; i < end; i += 2) {
      const Lanes d = pair_of(nodes.corrections[i], nodes.corrections[i + 1]);
      const Lanes x = pair_of(nodes.predicted[i], nodes.predicted[i + 1]) + d;
      const Lanes v = pair_of(nodes.predicted_velocity[i], nodes.predicted_velocity[i + 1]) + rate * d;
      const Lanes v_before = pair_of(nodes.velocity[i], nodes.velocity[i + 1]);
      nodes.predicted[i] = low_half(x);
      nodes.predicted[i + 1] = high_half(x);
      nodes.predicted_velocity[i] = low_half(v);
      nodes.predicted_velocity[i + 1] = high_half(v);
      const Lanes mass = __builtin_shufflevector(v, v, 3, 3, 3, 3, 7, 7, 7, 7);
      const Lanes mv = mass * v, mx = mass * x;
      mass_position += mx;
      momentum += mv;
      angular += cross_pairs(x, mv);
      before += cross_pairs(x, mass * v_before);
      squares += mx * x;
      products += mx * __builtin_shufflevector(x, x, 1, 2, 0, 3, 5, 6, 4, 7);
      kinetic += mv * v;
    }
    flush(sums.mass_position, mass_position);
    flush(sums.momentum, momentum);
    flush(sums.angular, angular);
    flush(sums.angular_before, before);
    double both[3] = {};
    flush(both, squares);
    for (int d = 0; d < 3; ++d) sums.second[d] += both[d];
    double mixed[3] = {};
    flush(mixed, products);
    for (int d = 0; d < 3; ++d) sums.second[d + 3] += mixed[d];
    double squared[3] = {};
    flush(squared, kinetic);
    sums.kinetic += 0.5 * (squared[0] + squared[1] + squared[2]);
  }
}

}  // namespace livegs
