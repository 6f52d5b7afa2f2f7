// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "wire/coding/rice_bits.h"
#include "wire/driver_grid.h"

// The integers of one object as bits: what is left of them after a prediction from frames before and, in a
// lattice, from nodes before; proto/frame_format.md, "Integers". Arithmetic wraps, so that any integers can
// be written and any bits read.

namespace livegs {

enum class Prediction : uint8_t {
  Intra = 0,   // from nothing
  Last = 1,    // the same place in the last frame
  Linear = 2,  // a straight line through the last two frames
  Curve = 3,   // through the last three, evenly spaced, with weights
};

// The last frames that held an object, in its form; what a prediction does not look at may be null. line:
// last + (last - earlier) * ahead / behind, towards zero. Curve: v = last - earlier, a = v - (earlier -
// earliest), last + (weight_v * v + weight_a * a) / 256, rounded down.
struct GridPast {
  const int32_t *last = nullptr, *earlier = nullptr, *earliest = nullptr;
  int32_t ahead = 1, behind = 1;  // ticks, above 0
  int32_t weight_v = 256, weight_a = 256;
};

// Weights are -2048 ... 2047.
inline constexpr int kWeightBits = 12;
// Low bits of a new object's integers, at least: so many that a few bytes cannot claim millions of drivers.
inline constexpr int kMinIntraBits = 5;
inline constexpr uint64_t kMinIntraDriverBits = 3 * (kMinIntraBits + 1);

// How large what is left is, by what is left beside it; grows with the frame, over all its objects.
inline constexpr size_t kMagnitudeClasses = 48;
struct GridScales {
  GridScales();
  std::array<RiceScale, kMagnitudeClasses> nodes;
  std::array<std::array<RiceScale, kMagnitudeClasses>, 2>
      drivers;                                    // positions, rotations: by the driver before
  std::array<std::array<RiceScale, 4>, 2> first;  // of an object: by its prediction
};

// Buffers that are kept from frame to frame.
struct GridScratch {
  std::vector<int32_t> predicted;
  std::vector<uint32_t> beside;
};

// Writes the grid's values, or reads them into it: its form, and room for them, are there. False where bits
// are missing.
template <class Bits>
bool code_values(Bits& bits, DriverGrid& grid, Prediction prediction, const GridPast& past,
                 GridScales& scales, GridScratch& scratch);

// A lattice's node coordinates, from which both ends find the neighbours. Writer: as given. Reader: as many
// as `coordinates` has room for.
template <class Bits>
bool code_coordinates(Bits& bits, std::vector<Eigen::Vector3i>& coordinates);

// Least squares over each fifth node. Both weights are whole numbers of 1/256.
void fit_curve(const DriverGrid& grid, GridPast& past);

// Sums of magnitudes that predictions from other frames leave in the first `channels` channels of each eighth
// driver, or of all if they are few; of those whose frames are not there, the most that can be.
struct PredictionCosts {
  uint64_t last, linear, curve;
};
PredictionCosts prediction_costs(const DriverGrid& grid, const GridPast& past, bool has_linear,
                                 bool has_curve);

}  // namespace livegs
