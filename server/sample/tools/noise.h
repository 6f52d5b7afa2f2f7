// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>

// Procedural noise from an integer hash: the same bits for the same point and seed, everywhere. One unit of
// the argument is one lattice cell; scale the point to choose a wavelength.

namespace livegs::sample {

// 64 well-mixed bits from a lattice point.
uint64_t lattice_hash(int64_t x, int64_t y, int64_t z, uint64_t seed);

// [0, 1).
double lattice_random(int64_t x, int64_t y, int64_t z, uint64_t seed);

// Value noise with quintic interpolation (C2), -1..1.
double value_noise(const Eigen::Vector3d& point, uint64_t seed);

// Sum of octaves, each at twice the frequency and half the amplitude, normalised to -1..1.
double fractal_noise(const Eigen::Vector3d& point, int octaves, uint64_t seed);

// Signed distance to the nearest of sparse dots, in cells, negative inside. One dot a lattice cell at most,
// with probability `density` and radius between the two bounds (at most 0.5 so that one ring of neighbours is
// enough).
double speckle_distance(const Eigen::Vector3d& point, double density, double min_radius, double max_radius,
                        uint64_t seed);

// 0 below `low`, 1 above `high`, smooth (C1) between.
double smooth_step(double low, double high, double value);

}  // namespace livegs::sample
