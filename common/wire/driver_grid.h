// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include "skin/driver_frame.h"
#include "wire/coding/grid_values.h"

// Drivers as integers, which is what both ends of a stream keep and predict from; proto/frame_format.md,
// "Grids".

namespace livegs {

// Steps of an elastic object's positions are 15/16 of powers of two of a metre, so that its integers stay
// comparable from frame to frame. The finest that is taken unasked, 57.2 µm, puts no node farther off than
// 0.05 mm.
inline constexpr double kStepPart = 0.9375;
struct GridPrecision {
  int position_bits =
      16;  // of an elastic object's longest side, 12 … 20: its step is at most side / (2^bits - 1) …
  int finest_exponent = -14;  // … and never finer than 15/16 of 2^finest_exponent metres (-14: 57 µm)
  int pose_exponent = -18;    // step of rigid positions, 2^pose_exponent metres (-18: 4 µm)
};

// What a client may ask for: 16 bits, 18 or 20, whose finest steps are 57, 14 and 3.6 µm. Rigid poses stay as
// they are.
constexpr bool may_ask_for(uint32_t position_bits) {
  return position_bits == 16 || position_bits == 18 || position_bits == 20;
}
constexpr GridPrecision precision_of(int position_bits) { return {position_bits, 2 - position_bits, -18}; }

inline constexpr int kStreamPoseBits = 18;  // a component of a rigid orientation: at most 0.0012 degrees off
inline constexpr int kStreamParticleBits = 12;  // of a particle's rotation: at most 0.07 degrees off
inline constexpr size_t kMaxGridChannels = 7;

// One object on its grid: `channels` arrays of `count` integers, one after the other. Channels 0 to 2 are x,
// y, z in steps; where there are rotations, 3 to 5 are the smallest three, lowest component first, and 6 the
// number of the one left out.
struct DriverGrid {
  uint32_t object_id = 0;
  DriverKind kind = DriverKind::Rigid;
  uint32_t revision = 0;
  bool asleep = false;
  int exponent = 0;  // a step is 2^exponent metres, of elastic objects 15/16 of it
  uint32_t count = 0;
  GridValues values;
  NodeNeighboursPtr neighbours;  // of a lattice; may be null

  size_t channels() const { return kind == DriverKind::Lattice ? 3 : kMaxGridChannels; }
  double step_m() const {
    return kind == DriverKind::Rigid ? std::ldexp(1.0, exponent) : kStepPart * std::ldexp(1.0, exponent);
  }
  bool operator==(const DriverGrid&) const = default;
};
// Whether integers of the one can be predicted from those of the other.
bool same_form(const DriverGrid& a, const DriverGrid& b);

// Puts an object's drivers on a grid. `before`, if there is one of the same kind and count, lends its step
// while that still fits, and the components that it leaves out while they are nearly the largest, so that
// integers change little, and its neighbours if they are the same. Preconditions: finite values; positions
// within 16 000 km.
DriverGrid to_grid(const ObjectDrivers& drivers, const DriverGrid* before, const GridPrecision& precision);

// The drivers that the integers stand for; what every client sees. Any integers give finite drivers and unit
// rotations.
ObjectDrivers from_grid(const DriverGrid& grid);

}  // namespace livegs
