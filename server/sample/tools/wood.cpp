// SPDX-License-Identifier: GPL-3.0-or-later
#include "sample/tools/wood.h"

#include <algorithm>
#include <cmath>

#include "sample/tools/colour.h"
#include "sample/tools/noise.h"

namespace livegs::sample {

using Eigen::Vector3d;

Vector3d wood_albedo(const Vector3d& p, const WoodTone& tone, uint64_t seed) {
  const Vector3d slow(p.x() / 0.25, p.y() / 0.05, p.z() / 0.05);
  const double y = p.y() + 0.010 * fractal_noise(slow, 2, seed + 1);
  const double z = p.z() + 0.010 * fractal_noise(slow + Vector3d(7.3, 1.7, 4.1), 2, seed + 2);
  const double ring = std::hypot(y, z) / tone.ring_m + 0.35 * value_noise(slow * 2.5, seed + 3);
  const double year = std::floor(ring), phase = ring - year;
  // Late wood increases through the year and ends abruptly in winter.
  double late = smooth_step(0.25, 0.88, phase) * smooth_step(1.0, 0.93, phase);
  late *= 0.55 + 0.45 * lattice_random(static_cast<int64_t>(year), 0, 0, seed + 4);
  Vector3d albedo = blend(tone.early, tone.late, late);
  const double fibre = fractal_noise(Vector3d(p.x() / 0.03, p.y() / 0.0016, p.z() / 0.0016), 2, seed + 5);
  const double cloud = fractal_noise(Vector3d(p.x() / 0.12, p.y() / 0.03, p.z() / 0.03), 2, seed + 6);
  albedo *= 1 + 0.11 * tone.detail * fibre + 0.09 * cloud;
  // Open pores: short dark dashes along the grain.
  const double pore = value_noise(Vector3d(p.x() / 0.012, p.y() / 0.0011, p.z() / 0.0011), seed + 7);
  return albedo * (1 - 0.22 * tone.detail * smooth_step(0.55, 0.85, pore));
}

}  // namespace livegs::sample
