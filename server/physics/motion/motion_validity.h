// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

// Bounds of a valid motion. A body outside them has diverged; its solver restores the last valid state.

namespace livegs {

// Speed limit, m/s; scenes stay below 100. Smaller: fast shots may be stopped. Larger: divergence is detected
// later.
inline constexpr double kMaxValidSpeed_m_s = 1e6;
// Coordinate limit per axis, m; scenes stay below 1000. Beyond it a double resolves only 0.1 µm, too coarse
// for contact.
inline constexpr double kMaxValidCoordinate_m = 1e9;

inline bool is_valid_position(const Eigen::Vector3d& position_m) {
  return position_m.allFinite() && position_m.cwiseAbs().maxCoeff() < kMaxValidCoordinate_m;
}

}  // namespace livegs
