// SPDX-License-Identifier: Apache-2.0
#include "wire/driver_grid.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <utility>

#include "core/assert.h"

namespace livegs {
namespace {

// Hysteresis of the omitted quaternion component: it is kept until another one is larger by this factor, so
// that near-ties do not alternate.
constexpr double kLeftOutHysteresis = 1.05;
// A body smaller than this fraction of the size for which its step was chosen gets a finer step.
constexpr double kMaxShrinkage = 0.35;
// Limit of the integers, 2^30, so that their second differences fit 32 bits.
constexpr double kMaxStepCount = 1073741824.0;

// Adding this constant leaves the integer part of a double, rounded to nearest, in its low bits.
constexpr double kRoundingBias = 6755399441055744.0;  // 1.5 * 2^52

int32_t rounded(double value) {
  return static_cast<int32_t>(static_cast<uint32_t>(std::bit_cast<uint64_t>(value + kRoundingBias)));
}

// Exponent of the smallest power of two that is >= `value`.
int exponent_above(double value) {
  int exponent;
  const double mantissa = std::frexp(value, &exponent);
  return mantissa == 0.5 ? exponent - 1 : exponent;
}

int coarse_enough(int exponent, double farthest_m) {
  if (!(farthest_m > 0.0)) return exponent;
  return std::max(exponent, exponent_above(farthest_m / kMaxStepCount));
}

// Smallest and largest coordinates, eight positions at a time: 24 lanes, each with a fixed axis.
std::pair<Eigen::Array3f, Eigen::Array3f> bounds_of(std::span<const Eigen::Vector3f> positions_m) {
  constexpr size_t kTogether = 8, kLanes = 3 * kTogether;
  std::array<float, kLanes> low, high;
  low.fill(std::numeric_limits<float>::infinity());
  high.fill(-std::numeric_limits<float>::infinity());
  size_t i = 0;
  for (; i + kTogether <= positions_m.size(); i += kTogether) {
    const float* const at = positions_m[i].data();
    for (size_t lane = 0; lane < kLanes; ++lane) {
      low[lane] = std::min(low[lane], at[lane]);
      high[lane] = std::max(high[lane], at[lane]);
    }
  }
  const auto fold = [](const std::array<float, kLanes>& lanes) {
    return Eigen::Map<const Eigen::Array<float, 3, kTogether>>(lanes.data());
  };
  Eigen::Array3f least = fold(low).rowwise().minCoeff(), most = fold(high).rowwise().maxCoeff();
  for (; i < positions_m.size(); ++i) {
    least = least.min(positions_m[i].array());
    most = most.max(positions_m[i].array());
  }
  return {least, most};
}

int lattice_exponent(const ObjectDrivers& drivers, const DriverGrid* before, const GridPrecision& precision) {
  const auto [low, high] = bounds_of(drivers.positions_m);
  const double side = static_cast<double>((high - low).maxCoeff());
  const double farthest =
      std::max(std::abs(static_cast<double>(low.minCoeff())), std::abs(static_cast<double>(high.maxCoeff())));
  LIVEGS_ASSERT(std::isfinite(side));
  const double steps = static_cast<double>((1 << precision.position_bits) - 1);
  const int fitting =
      coarse_enough(side > 0.0 ? std::max(precision.finest_exponent, exponent_above(side / steps / kStepPart))
                               : precision.finest_exponent,
                    farthest / kStepPart);
  if (!before) return fitting;
  const int kept = before->exponent;
  if (kept < fitting) return fitting;
  const bool shrunk =
      kept > precision.finest_exponent && side < kMaxShrinkage * steps * kStepPart * std::ldexp(1.0, kept);
  return shrunk ? fitting : kept;
}

int pose_exponent(const ObjectDrivers& drivers, const DriverGrid* before, const GridPrecision& precision) {
  double farthest = 0.0;
  for (const Pose& pose : drivers.poses) farthest = std::max(farthest, pose.position_m.cwiseAbs().maxCoeff());
  const int fitting = coarse_enough(precision.pose_exponent, farthest);
  return before ? std::max(before->exponent, fitting) : fitting;
}

// Smallest three of (x, y, z, w), with the sign that makes the omitted component positive; zero is exact.
void pack(const Eigen::Vector4d& v, int left_out, double scale, int32_t* a, int32_t* b, int32_t* c) {
  const double signed_scale = v[left_out] < 0.0 ? -scale : scale;
  int32_t* to[3] = {a, b, c};
  int next = 0;
  for (int i = 0; i < 4; ++i) {
    if (i != left_out) *to[next++] = rounded(v[i] * signed_scale);
  }
}

double rotation_scale(DriverKind kind) {
  const int bits = kind == DriverKind::Rigid ? kStreamPoseBits : kStreamParticleBits;
  return std::numbers::sqrt2 * static_cast<double>((1 << (bits - 1)) - 1);
}

template <class Coefficients>
void put_rotations(DriverGrid& grid, const DriverGrid* before, const Coefficients& coefficients) {
  const size_t n = grid.count;
  int32_t* const a = grid.values.data() + 3 * n;
  int32_t* const left = a + 3 * n;
  const double scale = rotation_scale(grid.kind);
  for (size_t i = 0; i < n; ++i) {
    const Eigen::Vector4d v = coefficients(i);
    Eigen::Index largest = 3;
    for (int k = 0; k < 3; ++k) {
      if (std::abs(v[k]) > std::abs(v[largest])) largest = k;
    }
    if (before) {
      const int32_t was = before->values[6 * n + i] & 3;
      if (std::abs(v[largest]) <= kLeftOutHysteresis * std::abs(v[was])) largest = was;
    }
    left[i] = static_cast<int32_t>(largest);
    pack(v, static_cast<int>(largest), scale, a + i, a + n + i, a + 2 * n + i);
  }
}

Eigen::Quaterniond rotation_at(const DriverGrid& grid, size_t i, double scale) {
  const size_t n = grid.count;
  const int32_t* const a = grid.values.data() + 3 * n + i;
  const int left_out = grid.values[6 * n + i] & 3;
  Eigen::Vector4d v = Eigen::Vector4d::Zero();
  int next = 0;
  for (int k = 0; k < 4; ++k) {
    if (k != left_out) v[k] = a[n * static_cast<size_t>(next++)] / scale;
  }
  v[left_out] = std::sqrt(std::max(0.0, 1.0 - v.squaredNorm()));
  return Eigen::Quaterniond(v).normalized();
}

}  // namespace

bool same_form(const DriverGrid& a, const DriverGrid& b) {
  return a.kind == b.kind && a.count == b.count && a.revision == b.revision && a.exponent == b.exponent &&
         a.neighbours == b.neighbours;
}

DriverGrid to_grid(const ObjectDrivers& drivers, const DriverGrid* before, const GridPrecision& precision) {
  DriverGrid grid;
  grid.object_id = drivers.object_id;
  grid.kind = drivers.kind;
  grid.revision = drivers.revision;
  grid.asleep = drivers.asleep;
  const bool rigid = drivers.kind == DriverKind::Rigid;
  grid.count = static_cast<uint32_t>(rigid ? drivers.poses.size() : drivers.positions_m.size());
  const size_t n = grid.count;
  if (before &&
      (before->kind != grid.kind || before->count != grid.count || before->revision != grid.revision))
    before = nullptr;
  if (drivers.kind == DriverKind::Lattice && drivers.neighbours && drivers.neighbours->before.size() == n) {
    const bool as_before =
        before && before->neighbours && same_neighbours(before->neighbours, drivers.neighbours);
    grid.neighbours = as_before ? before->neighbours : drivers.neighbours;
  }
  grid.values = GridValues(grid.channels() * n);
  if (n == 0) return grid;
  grid.exponent =
      rigid ? pose_exponent(drivers, before, precision) : lattice_exponent(drivers, before, precision);
  const double steps_per_m = 1.0 / grid.step_m();
  int32_t* const x = grid.values.data();
  if (rigid) {
    for (size_t i = 0; i < n; ++i) {
      for (size_t d = 0; d < 3; ++d)
        x[d * n + i] = rounded(drivers.poses[i].position_m[static_cast<Eigen::Index>(d)] * steps_per_m);
    }
  } else {
    const float* const at = drivers.positions_m[0].data();
    for (size_t d = 0; d < 3; ++d) {
      for (size_t i = 0; i < n; ++i) x[d * n + i] = rounded(static_cast<double>(at[3 * i + d]) * steps_per_m);
    }
  }
  if (rigid) {
    put_rotations(grid, before, [&](size_t i) { return drivers.poses[i].orientation.normalized().coeffs(); });
  } else if (drivers.kind == DriverKind::Particles) {
    LIVEGS_ASSERT(drivers.rotations.size() == n);
    put_rotations(grid, before, [&](size_t i) {
      return Eigen::Vector4d(drivers.rotations[i].cast<double>().normalized().coeffs());
    });
  }
  return grid;
}

ObjectDrivers from_grid(const DriverGrid& grid) {
  ObjectDrivers drivers;
  drivers.object_id = grid.object_id;
  drivers.kind = grid.kind;
  drivers.revision = grid.revision;
  drivers.asleep = grid.asleep;
  drivers.neighbours = grid.neighbours;
  const size_t n = grid.count;
  const double step_m = grid.step_m(), scale = rotation_scale(grid.kind);
  const int32_t* const x = grid.values.data();
  if (grid.kind == DriverKind::Rigid) {
    drivers.poses.resize(n);
    for (size_t i = 0; i < n; ++i) {
      drivers.poses[i] = {step_m * Eigen::Vector3d(x[i], x[n + i], x[2 * n + i]),
                          rotation_at(grid, i, scale)};
    }
    return drivers;
  }
  drivers.positions_m.resize(n);
  float* const at = n > 0 ? drivers.positions_m[0].data() : nullptr;
  for (size_t d = 0; d < 3; ++d) {
    for (size_t i = 0; i < n; ++i) at[3 * i + d] = static_cast<float>(step_m * x[d * n + i]);
  }
  if (grid.kind == DriverKind::Particles) {
    drivers.rotations.resize(n);
    for (size_t i = 0; i < n; ++i) drivers.rotations[i] = rotation_at(grid, i, scale).cast<float>();
  }
  return drivers;
}

}  // namespace livegs
