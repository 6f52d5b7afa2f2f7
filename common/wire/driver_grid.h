// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/result.h"
#include "skin/driver_frame.h"

// Drivers as integers, which is what both ends of a stream keep and predict from; proto/frame_format.md,
// "Grids".

namespace livegs {

// Steps of positions are powers of two of a metre, so that an object's integers stay comparable from frame to
// frame.
struct GridPrecision {
  int position_bits =
      16;  // of an elastic object's longest side, 12 … 20: its step is at most side / (2^bits - 1) …
  int finest_exponent = -15;  // … and never finer than 2^finest_exponent metres (-15: 31 µm)
  int pose_exponent = -18;    // step of rigid positions, 2^pose_exponent metres (-18: 4 µm)
};

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
  int exponent = 0;  // a step is 2^exponent metres
  uint32_t count = 0;
  std::vector<int32_t> values;

  size_t channels() const { return kind == DriverKind::Lattice ? 3 : kMaxGridChannels; }
  bool operator==(const DriverGrid&) const = default;
};

// Puts an object's drivers on a grid. `before`, if there is one of the same kind and count, lends its step
// while that still fits, and the components that it leaves out while they are nearly the largest, so that
// integers change little. Preconditions: finite values; positions within 16 000 km.
DriverGrid to_grid(const ObjectDrivers& drivers, const DriverGrid* before, const GridPrecision& precision);

// The drivers that the integers stand for; what every client sees. Any integers give finite drivers and unit
// rotations.
ObjectDrivers from_grid(const DriverGrid& grid);

}  // namespace livegs
