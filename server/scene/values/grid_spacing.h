// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

namespace livegs {

// The step of the cubic grid that points strayed from, each by less than half of it, or 0 where none is seen.
// Looked for along the world's axes and along the points' own, between 0.9 and 1.8 times `nearest_m`, their
// median distance to the nearest other point. By the structure factor, as a powder's lattice constant is
// found by diffraction: its peak stays where it is however far points stray at random, only lower, by sinc(2
// pi j) where each strays by up to j of a step.
double grid_spacing_m(const std::vector<Eigen::Vector3d>& points_m, double nearest_m);

}  // namespace livegs
