// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace livegs {

// A block of 0.2 x 0.1 x 0.2 m, 4 kg, 20 kPa and nu 0.3 under its weight and a 1 kg sphere of 5 cm that
// slides on it without friction, at rest: linear elasticity, trilinear elements, no part of the solver that
// is tested.
struct SettledBlock {
  double element_m = 0.0125;  // divides the sides
  double point_m =
      0.0125;          // how far apart the points of the top are that the sphere may not enter; divides 0.2 m
  bool glued = false;  // to the floor; else it slides there freely. Friction is between the two
};

// How far the sphere's lowest point is below the top of the block without loads; within 1e-6 m.
double settled_depth_m(const SettledBlock& block);

}  // namespace livegs
