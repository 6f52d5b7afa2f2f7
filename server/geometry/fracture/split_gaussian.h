// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "geometry/fracture/voronoi_pieces.h"

// Inside the room: one Gaussian shared out among the Voronoi cells it reaches into.

namespace livegs {

// A plane, by the cells on its sides, the lower first.
using CutName = std::pair<uint32_t, uint32_t>;

struct GaussianPart {
  Eigen::Vector3d mean_m;
  Eigen::Matrix3d covariance_m2;
  double opacity = 1.0;  // of the peak, in parts of the original's
  uint32_t cell = 0;
  std::vector<CutName> cuts = {}, narrowed = {};  // planes it was cut at; for which it was made narrower
};

struct SplitLimits {
  double max_overhang_m;  // across a plane, at kSplitDeviations
  double min_opacity;     // in parts of the original's; parts below are left out, but for the first
};

// An ellipsoid of this many standard deviations counts as the kernel: outside, its opacity is under a 90th of
// the peak.
inline constexpr double kSplitDeviations = 3.0;

// The parts of a Gaussian; the first is in the cell of its mean. One part, equal to the Gaussian, if no plane
// between two pieces crosses it, or only so that nobody sees it.
std::vector<GaussianPart> split_gaussian(const Eigen::Vector3d& mean_m, const Eigen::Matrix3d& covariance_m2,
                                         const VoronoiPieces& pieces, const SplitLimits& limits);

}  // namespace livegs
