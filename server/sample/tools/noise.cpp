// SPDX-License-Identifier: GPL-3.0-or-later
// Value noise after Lewis 1989; the hash is the finaliser of splitmix64 (Steele et al. 2014).
#include "sample/tools/noise.h"

#include <algorithm>
#include <cmath>

namespace livegs::sample {
namespace {

uint64_t mix(uint64_t bits) {
  bits = (bits ^ (bits >> 30)) * 0xBF58476D1CE4E5B9ull;
  bits = (bits ^ (bits >> 27)) * 0x94D049BB133111EBull;
  return bits ^ (bits >> 31);
}

double quintic(double t) { return t * t * t * (t * (t * 6.0 - 15.0) + 10.0); }

}  // namespace

uint64_t lattice_hash(int64_t x, int64_t y, int64_t z, uint64_t seed) {
  const uint64_t key = static_cast<uint64_t>(x) * 0x9E3779B97F4A7C15ull ^
                       static_cast<uint64_t>(y) * 0xC2B2AE3D27D4EB4Full ^
                       static_cast<uint64_t>(z) * 0x165667B19E3779F9ull;
  return mix(key + mix(seed + 0x9E3779B97F4A7C15ull));
}

double lattice_random(int64_t x, int64_t y, int64_t z, uint64_t seed) {
  return static_cast<double>(lattice_hash(x, y, z, seed) >> 11) * 0x1.0p-53;
}

double value_noise(const Eigen::Vector3d& point, uint64_t seed) {
  const Eigen::Vector3d cell = point.array().floor();
  const Eigen::Vector3d inside = point - cell;
  const int64_t x = static_cast<int64_t>(cell.x()), y = static_cast<int64_t>(cell.y()),
                z = static_cast<int64_t>(cell.z());
  const double wx = quintic(inside.x()), wy = quintic(inside.y()), wz = quintic(inside.z());
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const int dx = corner & 1, dy = (corner >> 1) & 1, dz = corner >> 2;
    const double weight = (dx ? wx : 1 - wx) * (dy ? wy : 1 - wy) * (dz ? wz : 1 - wz);
    sum += weight * lattice_random(x + dx, y + dy, z + dz, seed);
  }
  return 2.0 * sum - 1.0;
}

double fractal_noise(const Eigen::Vector3d& point, int octaves, uint64_t seed) {
  double sum = 0.0, amplitude = 1.0, total = 0.0, frequency = 1.0;
  for (int octave = 0; octave < octaves; ++octave) {
    sum += amplitude * value_noise(point * frequency, seed + static_cast<uint64_t>(octave));
    total += amplitude;
    amplitude *= 0.5;
    frequency *= 2.0;
  }
  return total > 0.0 ? sum / total : 0.0;
}

double speckle_distance(const Eigen::Vector3d& point, double density, double min_radius, double max_radius,
                        uint64_t seed) {
  const Eigen::Vector3d cell = point.array().floor();
  double nearest = 1.0;
  for (int dz = -1; dz <= 1; ++dz)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const int64_t x = static_cast<int64_t>(cell.x()) + dx, y = static_cast<int64_t>(cell.y()) + dy,
                      z = static_cast<int64_t>(cell.z()) + dz;
        if (lattice_random(x, y, z, seed) >= density) continue;
        const Eigen::Vector3d centre(static_cast<double>(x) + lattice_random(x, y, z, seed + 1),
                                     static_cast<double>(y) + lattice_random(x, y, z, seed + 2),
                                     static_cast<double>(z) + lattice_random(x, y, z, seed + 3));
        const double radius = min_radius + (max_radius - min_radius) * lattice_random(x, y, z, seed + 4);
        nearest = std::min(nearest, (point - centre).norm() - radius);
      }
  return nearest;
}

double smooth_step(double low, double high, double value) {
  const double t = std::clamp((value - low) / (high - low), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

}  // namespace livegs::sample
