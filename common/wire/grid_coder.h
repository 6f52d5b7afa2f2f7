// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "wire/coding/rice_bits.h"
#include "wire/driver_grid.h"

// Codes the integers of one object as bits: the residuals after a prediction from earlier frames and, in a
// lattice, from earlier nodes. Layout: proto/frame_format.md, "Integers". Arithmetic wraps, so any integers
// can be written and any bits read.

namespace livegs {

enum class Prediction : uint8_t {
  Intra = 0,   // no prediction
  Last = 1,    // the same place in the last frame
  Linear = 2,  // straight line through the last two frames
  Curve = 3,   // curve through the last three, evenly spaced frames, with weights
};

// The last frames that held an object, in the same form; frames that the prediction does not use may be null.
//   Line: last + (last - earlier) * ahead / behind, rounded towards zero.
//   Curve: v = last - earlier, a = v - (earlier - earliest), last + (weight_v * v + weight_a * a) / 256,
//     rounded down.
struct GridPast {
  const int32_t *last = nullptr, *earlier = nullptr, *earliest = nullptr;
  int32_t ahead = 1, behind = 1;  // ticks, above 0
  int32_t weight_v = 256, weight_a = 256;
};

// Weights are -2048 to 2047.
inline constexpr int kWeightBits = 12;
// Minimum low bits per integer of a new object. Prevents a few bytes from claiming millions of drivers.
inline constexpr int kMinIntraBits = 5;
inline constexpr uint64_t kMinIntraDriverBits = 3 * (kMinIntraBits + 1);

// Scales of the residuals by the size of the neighbouring residuals. Adapted over all objects of a frame.
inline constexpr size_t kMagnitudeClasses = 48;
struct GridScales {
  GridScales();
  std::array<RiceScale, kMagnitudeClasses> nodes;
  // positions, rotations: by the residual of the driver before
  std::array<std::array<RiceScale, kMagnitudeClasses>, 2> drivers;
  std::array<std::array<RiceScale, 4>, 2> first;  // first driver of an object: by its prediction
};

// Buffers reused from frame to frame.
struct GridScratch {
  std::vector<int32_t> predicted;
  std::vector<uint32_t> neighbours;
};

// Writes the values of the grid, or reads them into it. The grid already has its form and its size. False if
// bits are missing.
template <class Bits>
bool code_values(Bits& bits, DriverGrid& grid, Prediction prediction, const GridPast& past,
                 GridScales& scales, GridScratch& scratch);

// Node coordinates of a lattice, from which both ends compute the neighbours. The writer passes them; the
// reader fills `coordinates`, which has the right size.
template <class Bits>
bool code_coordinates(Bits& bits, std::vector<Eigen::Vector3i>& coordinates);

// Least-squares fit over every fifth node. Both weights are multiples of 1/256.
void fit_curve(const DriverGrid& grid, GridPast& past);

// Residual magnitudes summed over the first `channels` channels of every eighth driver, or of all drivers if
// there are few. Predictions without the required frames have the largest value.
struct PredictionCosts {
  uint64_t last, linear, curve;
};
PredictionCosts prediction_costs(const DriverGrid& grid, const GridPast& past, bool has_linear,
                                 bool has_curve);

}  // namespace livegs
