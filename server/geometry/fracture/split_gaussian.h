// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "geometry/fracture/voronoi_pieces.h"

// Private to the geometry room. Splits one Gaussian among the Voronoi cells that it overlaps.

namespace livegs {

// A plane, identified by the cells on its sides, lower number first.
using CutName = std::pair<uint32_t, uint32_t>;

struct GaussianPart {
  Eigen::Vector3d mean_m;
  Eigen::Matrix3d covariance_m2;
  double opacity = 1.0;  // peak opacity relative to the original
  uint32_t cell = 0;
  std::vector<CutName> cuts = {}, narrowed = {};  // planes that cut it; planes that it was narrowed for
};

struct SplitLimits {
  double max_overhang_m;  // across a plane, at kSplitDeviations
  double min_opacity;     // relative to the original; fainter parts are dropped except the first
};

// Radius of a kernel's ellipsoid in standard deviations. Outside, its opacity is under a 90th of the peak.
inline constexpr double kSplitDeviations = 3.0;

// Splits a Gaussian into parts; the first one is in the cell of its mean. Returns the Gaussian unchanged if
// no plane between two pieces crosses it visibly.
std::vector<GaussianPart> split_gaussian(const Eigen::Vector3d& mean_m, const Eigen::Matrix3d& covariance_m2,
                                         const VoronoiPieces& pieces, const SplitLimits& limits);

}  // namespace livegs
