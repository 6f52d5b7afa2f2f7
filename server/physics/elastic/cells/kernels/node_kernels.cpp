// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/elastic/cells/kernels/node_kernels.h"

namespace livegs {
namespace {

LIVEGS_INLINE void flush(double (&sum)[3], Lanes& part) {
  for (int d = 0; d < 3; ++d) sum[d] += static_cast<double>(part[d]) + static_cast<double>(part[d + 4]);
  part = all_lanes(0.0f);
}

// Two nodes.
LIVEGS_INLINE Lanes load(const NodeLanes* nodes) { return pair_of(nodes[0], nodes[1]); }
LIVEGS_INLINE void store(Lanes values, NodeLanes* nodes) {
  nodes[0] = low_half(values);
  nodes[1] = high_half(values);
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
    const Lanes x = load(nodes.position + i);
    const Lanes x_before = load(nodes.predicted + i);
    Lanes v = load(nodes.velocity + i);
    const Lanes v_before = load(nodes.predicted_velocity + i);
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
    store(v, nodes.velocity + i);
    store(out, nodes.predicted_velocity + i);
    store(y, nodes.predicted + i);
    store(zero, nodes.corrections + i);
  }
}

float shift_nodes(const NodeArrays& nodes, NodeLanes by, NodeLanes centre) {
  const Lanes both = twice(by), middle = twice(centre);
  Lanes furthest = all_lanes(0.0f);
  for (size_t i = 0; i < nodes.count; i += 2) {
    const Lanes x = load(nodes.position + i) + both;
    const Lanes before = load(nodes.predicted + i) + both;
    store(x, nodes.position + i);
    store(before, nodes.predicted + i);
    const Lanes r = x - middle, square = r * r;
    const Lanes sum = square + __builtin_shufflevector(square, square, 1, 2, 0, 3, 5, 6, 4, 7) +
                      __builtin_shufflevector(square, square, 2, 0, 1, 3, 6, 4, 5, 7);
    furthest = sum > furthest ? sum : furthest;
  }
  return furthest[0] > furthest[4] ? furthest[0] : furthest[4];
}

void advance_nodes(const NodeArrays& nodes, float step_s, NodeSums& sums) {
  const Lanes rate = all_lanes(1.0f / step_s), zero = all_lanes(0.0f);
  const size_t block = 32;  // nodes summed in single precision before the addition to the double sums
  sums = NodeSums{};
  for (size_t begin = 0; begin < nodes.count; begin += block) {
    const size_t end = begin + block < nodes.count ? begin + block : nodes.count;
    Lanes mass_position = zero, momentum = zero, angular = zero, before = zero, squares = zero,
          products = zero;
    Lanes kinetic = zero;
    for (size_t i = begin; i < end; i += 2) {
      const Lanes d = load(nodes.corrections + i);
      const Lanes x = load(nodes.predicted + i) + d;
      const Lanes v = load(nodes.predicted_velocity + i) + rate * d;
      const Lanes v_before = load(nodes.velocity + i);
      store(x, nodes.predicted + i);
      store(v, nodes.predicted_velocity + i);
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
    flush(sums.squares, squares);
    flush(sums.products, products);
    double squared[3] = {};
    flush(squared, kinetic);
    sums.kinetic += 0.5 * (squared[0] + squared[1] + squared[2]);
  }
}

}  // namespace livegs
