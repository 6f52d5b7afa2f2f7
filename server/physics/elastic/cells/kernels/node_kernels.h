// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "physics/elastic/cells/kernels/cell_lanes.h"

// The inner loops of the `cells` solver over nodes, as plain functions over flat arrays: what a substep does
// before the sweep over cells and after it. Single precision, lengths relative to an origin near the body.

namespace livegs {

// The nodes of a body. `position` and `predicted` hold the inverse mass in w (0: the node is held),
// `velocity` and `predicted_velocity` the mass.
//   before predict: position x, predicted x_ (a step ago), velocity v, predicted_velocity v_
//   after predict:  predicted y, predicted_velocity v^; corrections 0
//   after advance:  predicted x', predicted_velocity v'; the caller swaps
// Arrays are a multiple of two nodes long; a padding node has mass and inverse mass 0.
struct NodeArrays {
  size_t count = 0;  // a multiple of 2
  NodeLanes* position = nullptr;
  NodeLanes* predicted = nullptr;
  NodeLanes* velocity = nullptr;
  NodeLanes* predicted_velocity = nullptr;
  NodeLanes* corrections = nullptr;
};

// Vectors with w = 0.
struct PredictStep {
  float memory = 0;                       // 1/3 of BDF2, 0 of BDF1
  float step_s = 0;                       // h_e
  float kept = 1;                         // of the deviation from rigid motion
  NodeLanes centre;                       // of mass
  NodeLanes correction, correction_spin;  // of v, before anything else: what the momentum ledger owes
  NodeLanes bias, spin;                   // v^ = kept (v + memory (v - v_)) + bias + spin x r
};
void predict_nodes(const NodeArrays& nodes, const PredictStep& step);

// Sums over nodes after the step, about the arrays' origin.
struct NodeSums {
  double mass_position[3] = {}, momentum[3] = {}, angular[3] = {};
  double angular_before[3] = {};  // sum m x' x v: of the velocities before the step where the nodes are now
  double second[6] = {};          // sum m: xx, yy, zz, xy, yz, zx
  double kinetic = 0;             // sum m v'^2 / 2
};
void advance_nodes(const NodeArrays& nodes, float step_s, NodeSums& sums);

// Moves all nodes, now and a step ago, and gives the largest squared distance from `centre` (after it), m^2.
// Vectors with w = 0; `nodes.count` may leave out the spare nodes but is a multiple of 2.
float shift_nodes(const NodeArrays& nodes, NodeLanes by, NodeLanes centre);

}  // namespace livegs
