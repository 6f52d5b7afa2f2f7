// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace livegs {

// Hard limits of every answer. Kilograms, pascals, metres.
struct ValueRange {
  double low, high;
  bool holds(double value) const { return value >= low && value <= high; }  // false for NaN
};
inline constexpr ValueRange kMassRange_kg{1e-6, 2e4};  // a petal, a lorry
inline constexpr ValueRange kYoungsRange_pa{100, 3e11};
inline constexpr ValueRange kStructureRange{1e-3, 1};
inline constexpr ValueRange kUnitRange{0, 1};
inline constexpr ValueRange kFrictionRange{0, 2};
inline constexpr ValueRange kWallRange_m{1e-5, 1};
inline constexpr ValueRange kSizeRange_m{1e-4, 1000};
// A range with a larger ratio of high to low carries no information.
inline constexpr double kMaxRangeRatio = 20.0;

}  // namespace livegs
