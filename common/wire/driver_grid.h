// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include "skin/driver_frame.h"
#include "wire/coding/grid_values.h"

// Drivers as integers: the form that both ends of a stream store and predict from. See proto/frame_format.md,
// "Grids".

namespace livegs {

// Position steps of elastic objects are this fraction of a power of two of a metre, so that integers stay
// comparable between frames. The finest default step, 57.2 µm, keeps nodes within 0.05 mm.
inline constexpr double kStepPart = 0.9375;
struct GridPrecision {
  // of the longest side of an elastic object, 12 to 20: its step is at most side / (2^bits - 1)
  int position_bits = 16;
  int finest_exponent = -14;  // lower limit of the step: 15/16 of 2^finest_exponent metres (-14: 57 µm)
  int pose_exponent = -18;    // step of rigid positions, 2^pose_exponent metres (-18: 4 µm)
};

// Whether a client may request these position bits: 16, 18 or 20, with finest steps of 57, 14 and 3.6 µm.
// Rigid poses are not affected.
constexpr bool may_ask_for(uint32_t position_bits) {
  return position_bits == 16 || position_bits == 18 || position_bits == 20;
}
constexpr GridPrecision precision_of(int position_bits) { return {position_bits, 2 - position_bits, -18}; }

// per component of a rigid orientation; error at most 0.0012 degrees
inline constexpr int kStreamPoseBits = 18;
// per component of a particle rotation; error at most 0.07 degrees
inline constexpr int kStreamParticleBits = 12;
inline constexpr size_t kMaxGridChannels = 7;

// One object on its grid: `channels` arrays of `count` integers, one after the other. Channels 0 to 2 are x,
// y, z in steps. With rotations, channels 3 to 5 are the smallest three, lowest component first, and channel
// 6 is the index of the omitted component.
struct DriverGrid {
  uint32_t object_id = 0;
  DriverKind kind = DriverKind::Rigid;
  uint32_t revision = 0;
  bool asleep = false;
  int exponent = 0;  // a step is 2^exponent metres; for elastic objects 15/16 of it
  uint32_t count = 0;
  GridValues values;
  NodeNeighboursPtr neighbours;  // lattice only; may be null

  size_t channels() const { return kind == DriverKind::Lattice ? 3 : kMaxGridChannels; }
  double step_m() const {
    return kind == DriverKind::Rigid ? std::ldexp(1.0, exponent) : kStepPart * std::ldexp(1.0, exponent);
  }
  bool operator==(const DriverGrid&) const = default;
};
// Whether integers of one grid can be predicted from those of the other.
bool same_form(const DriverGrid& a, const DriverGrid& b);

// Quantises the drivers of an object. `before`, if it has the same kind and count, provides its step while
// that still fits, its omitted components while they are nearly the largest, and its neighbours if they are
// equal. This keeps integer changes small. Preconditions: finite values; positions within 16 000 km.
DriverGrid to_grid(const ObjectDrivers& drivers, const DriverGrid* before, const GridPrecision& precision);

// The drivers of a grid, as every client sees them. Any integers give finite drivers and unit rotations.
ObjectDrivers from_grid(const DriverGrid& grid);

}  // namespace livegs
