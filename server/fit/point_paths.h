// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

namespace livegs {

// Positions of points at every tick of a simulation, world frame.
struct PointPaths {
  double rate_hz = 0;
  size_t points = 0;
  std::vector<Eigen::Vector3f> positions_m;  // tick-major

  size_t ticks() const { return points == 0 ? 0 : positions_m.size() / points; }
  // Position at a time, by cubic interpolation between ticks (Catmull and Rom 1974). Its error is below 1 %
  // of the amplitude at a ninth of the rate. Times are clamped to the first and the last tick.
  Eigen::Vector3d at(size_t point, double time_s) const;
};

}  // namespace livegs
