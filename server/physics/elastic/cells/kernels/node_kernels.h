// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "physics/elastic/cells/kernels/cell_lanes.h"

// Inner loops of the `cells` solver over nodes, as plain functions on flat arrays: the parts of a substep
// before and after the sweep over cells. Single precision, lengths relative to an origin near the body.

namespace livegs {

// The nodes of a body. `position` and `predicted` hold the inverse mass in w (0: the node is held),
// `velocity` and `predicted_velocity` the mass.
//   before predict: position x, predicted x_ (previous step), velocity v, predicted_velocity v_
//   after predict:  predicted y, predicted_velocity v^; corrections 0
//   after advance:  predicted x', predicted_velocity v'; the caller swaps
// Arrays have an even number of nodes; a padding node has mass and inverse mass 0.
struct NodeArrays {
  size_t count = 0;  // even
  NodeLanes* position = nullptr;
  NodeLanes* predicted = nullptr;
  NodeLanes* velocity = nullptr;
  NodeLanes* predicted_velocity = nullptr;
  NodeLanes* corrections = nullptr;
};

// Vectors have w = 0.
struct PredictStep {
  float memory = 0;                       // 1/3 for BDF2, 0 for BDF1
  float step_s = 0;                       // h_e
  float kept = 1;                         // factor on the deviation from rigid motion
  NodeLanes centre;                       // centre of mass
  NodeLanes correction, correction_spin;  // added to v first: correction by the momentum ledger
  // v^ = kept (v + memory (v - v_)) + bias + spin x r + field r, with the columns of a matrix.
  NodeLanes bias, spin, field[3];
};
void predict_nodes(const NodeArrays& nodes, const PredictStep& step);

// Sums over all nodes after the step, about the origin of the arrays.
struct NodeSums {
  double mass_position[3] = {}, momentum[3] = {}, angular[3] = {};
  double angular_before[3] = {};             // sum m x' x v: velocities before the step at the new positions
  double squares[3] = {}, products[3] = {};  // sum m times xx, yy, zz; xy, yz, zx
  double kinetic = 0;                        // sum m v'^2 / 2
};
void advance_nodes(const NodeArrays& nodes, float step_s, NodeSums& sums);

// Shifts all nodes, in the current and the previous state. Returns the largest squared distance from `centre`
// afterwards, m². Vectors have w = 0. `nodes.count` may exclude the spare nodes but must be even.
float shift_nodes(const NodeArrays& nodes, NodeLanes by, NodeLanes centre);

}  // namespace livegs
