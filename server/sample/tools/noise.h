// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>

// Procedural noise from an integer hash. The same point and seed give the same bits on all platforms. One
// unit of the argument is one lattice cell; scale the point to choose a wavelength.

namespace livegs::sample {

// Returns 64 hashed bits of a lattice point.
uint64_t lattice_hash(int64_t x, int64_t y, int64_t z, uint64_t seed);

// Returns a value in [0, 1).
double lattice_random(int64_t x, int64_t y, int64_t z, uint64_t seed);

// Value noise with quintic interpolation (C2), range -1..1.
double value_noise(const Eigen::Vector3d& point, uint64_t seed);

// Sum of octaves, each with twice the frequency and half the amplitude, normalised to -1..1.
double fractal_noise(const Eigen::Vector3d& point, int octaves, uint64_t seed);

// Signed distance to the nearest of sparse dots, in cells, negative inside. Each lattice cell has at most one
// dot, with probability `density` and a radius between the two bounds (at most 0.5, so that one ring of
// neighbours is sufficient).
double speckle_distance(const Eigen::Vector3d& point, double density, double min_radius, double max_radius,
                        uint64_t seed);

// Returns 0 below `low`, 1 above `high`, smooth (C1) in between.
double smooth_step(double low, double high, double value);

}  // namespace livegs::sample
