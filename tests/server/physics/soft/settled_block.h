// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace livegs {

// A block of 0.2 x 0.1 x 0.2 m, 4 kg, 20 kPa and nu 0.3 at rest under its weight and a sphere of 1 kg and 5
// cm radius that slides on it without friction. Linear elasticity with trilinear elements, independent of the
// solver under test.
struct SettledBlock {
  double element_m = 0.0125;  // element edge; must divide the sides
  double point_m = 0.0125;    // spacing of the top points that the sphere may not enter; must divide 0.2 m
  bool glued = false;         // glued to the floor; otherwise it slides freely. Friction is between the two
};

// Depth of the sphere's lowest point below the top of the unloaded block, m; accurate to 1e-6 m.
double settled_depth_m(const SettledBlock& block);

}  // namespace livegs
