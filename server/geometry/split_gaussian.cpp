// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/split_gaussian.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/truncated_gaussian.h"

namespace livegs {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// A Gaussian much larger than the body would become thousands of parts; at this many they are held back instead.
constexpr size_t kMostParts = 96;
// Of the variance that stays with each of three narrower Gaussians that stand for one.
constexpr double kNarrowing = 0.5;

// The nearest plane that the part's ellipsoid crosses.
struct Crossing {
  uint32_t neighbour = ~0u;
  Vector3d normal = Vector3d::UnitX();  // out of the part's cell
  double deviation_m = 0.0;             // standard deviation along it
  double end = 0.0;                     // the plane, in deviations from the mean
};

bool one_piece(const VoronoiPieces& pieces, uint32_t a, uint32_t b) {
  const auto &pa = pieces.cell_parts[a], &pb = pieces.cell_parts[b];
  return pa.size() == 1 && pb.size() == 1 && pa[0].piece == pb[0].piece;
}

Crossing plane_between(const GaussianPart& part, const VoronoiPieces& pieces, uint32_t neighbour) {
  Crossing crossing;
  crossing.neighbour = neighbour;
  const Vector3d &here = pieces.seeds_m[part.cell], &there = pieces.seeds_m[neighbour];
  crossing.normal = (there - here).normalized();
  crossing.deviation_m = std::sqrt(std::max(0.0, crossing.normal.dot(part.covariance_m2 * crossing.normal)));
  const double distance_m = crossing.normal.dot(0.5 * (here + there) - part.mean_m);
  crossing.end = distance_m / std::max(crossing.deviation_m, 1e-300);
  return crossing;
}

Crossing nearest_crossing(const GaussianPart& part, const VoronoiPieces& pieces) {
  Crossing nearest;
  nearest.end = kSplitDeviations;
  for (uint32_t neighbour : pieces.cell_neighbours[part.cell]) {
    const std::pair<uint32_t, uint32_t> planes = std::minmax(part.cell, neighbour);
    if (std::find(part.cuts.begin(), part.cuts.end(), planes) != part.cuts.end()) continue;
    if (one_piece(pieces, part.cell, neighbour)) continue;
    const Crossing crossing = plane_between(part, pieces, neighbour);
    if (crossing.end < nearest.end) nearest = crossing;
  }
  return nearest;
}

// What lies below `end` deviations along `normal`.
GaussianPart below(const GaussianPart& part, const Vector3d& normal, double deviation_m, double end) {
  const TruncatedNormal cut = normal_below(end);
  const Vector3d along = part.covariance_m2 * normal / deviation_m;
  GaussianPart half = part;
  half.mean_m += cut.mean * along;
  half.covariance_m2 -= (1.0 - cut.variance) * along * along.transpose();
  half.opacity *= cut.mass / std::sqrt(cut.variance);
  return half;
}

// Three narrower Gaussians along the normal with the same moments up to the fifth, by the Gauss-Hermite rule of three
// points: a Gaussian of variance 1 is one of variance v convolved with one of 1 - v, which the rule puts at 0 and at
// +-sqrt(3 (1 - v)) with weights 2/3 and 1/6.
std::array<GaussianPart, 3> narrower(const GaussianPart& part, const Crossing& crossing) {
  const Vector3d along = part.covariance_m2 * crossing.normal / crossing.deviation_m;
  const double offset = std::sqrt(3.0 * (1.0 - kNarrowing));
  std::array<GaussianPart, 3> three{part, part, part};
  for (int k = 0; k < 3; ++k) {
    three[k].mean_m += (k - 1) * offset * along;
    three[k].covariance_m2 -= (1.0 - kNarrowing) * along * along.transpose();
    three[k].opacity *= (k == 1 ? 2.0 / 3.0 : 1.0 / 6.0) / std::sqrt(kNarrowing);
  }
  return three;
}

double overhang_m(const Crossing& crossing) {
  const TruncatedNormal low = normal_below(crossing.end), high = normal_below(-crossing.end);
  return crossing.deviation_m * std::max(kSplitDeviations * std::sqrt(low.variance) + low.mean - crossing.end,
                                         kSplitDeviations * std::sqrt(high.variance) + high.mean + crossing.end);
}

// Rounding, other planes' cuts and kMostParts may leave a part reaching too far: it is pressed flat until it does not.
void hold_back(GaussianPart& part, const VoronoiPieces& pieces, double most_overhang_m) {
  for (uint32_t neighbour : pieces.cell_neighbours[part.cell]) {
    if (one_piece(pieces, part.cell, neighbour)) continue;
    const Crossing crossing = plane_between(part, pieces, neighbour);
    const double distance_m = crossing.end * crossing.deviation_m;
    const double reach_m = std::max(distance_m + most_overhang_m, 0.1 * most_overhang_m);
    const double share = reach_m / (kSplitDeviations * std::max(crossing.deviation_m, 1e-300));
    if (share >= 1.0) continue;
    const Vector3d along = part.covariance_m2 * crossing.normal / crossing.deviation_m;
    part.covariance_m2 -= (1.0 - share * share) * along * along.transpose();
  }
}

}  // namespace

std::vector<GaussianPart> split_gaussian(const Vector3d& mean_m, const Matrix3d& covariance_m2,
                                         const VoronoiPieces& pieces, const SplitLimits& limits) {
  const GaussianPart whole{mean_m, covariance_m2, 1.0, pieces.cell_at(mean_m)};
  std::vector<GaussianPart> open{whole}, done;
  while (!open.empty()) {
    GaussianPart part = std::move(open.back());
    open.pop_back();
    const Crossing crossing = nearest_crossing(part, pieces);
    if (crossing.neighbour == ~0u || done.size() + open.size() >= kMostParts) {
      done.push_back(std::move(part));
      continue;
    }
    const std::pair<uint32_t, uint32_t> planes = std::minmax(part.cell, crossing.neighbour);
    if (crossing.end <= -kSplitDeviations) {  // wholly in the neighbour
      part.cell = crossing.neighbour;
      part.cuts.push_back(planes);
      open.push_back(std::move(part));
      continue;
    }
    const GaussianPart high = below(part, -crossing.normal, crossing.deviation_m, -crossing.end);
    const double reach_m = (kSplitDeviations - crossing.end) * crossing.deviation_m;
    if (high.opacity < limits.least_opacity && reach_m <= limits.most_overhang_m) {
      part.cuts.push_back(planes);
      open.push_back(std::move(part));
      continue;
    }
    if (overhang_m(crossing) > limits.most_overhang_m) {
      for (GaussianPart& narrow : narrower(part, crossing)) {
        if (narrow.opacity >= limits.least_opacity) open.push_back(std::move(narrow));
      }
      continue;
    }
    GaussianPart low = below(part, crossing.normal, crossing.deviation_m, crossing.end);
    low.cuts.push_back(planes);
    open.push_back(std::move(low));
    open.push_back(high);
    open.back().cell = crossing.neighbour;
    open.back().cuts.push_back(planes);
  }
  // The largest part in the cell of the mean first; the order of the others is that of their making.
  size_t first = 0;
  double most = -1.0;
  for (size_t k = 0; k < done.size(); ++k) {
    if (done[k].cell == whole.cell && done[k].opacity > most) most = done[k].opacity, first = k;
  }
  if (most < 0.0) {  // all of it was too faint: it stays as it was
    done.assign(1, whole);
    first = 0;
  }
  std::rotate(done.begin(), done.begin() + static_cast<std::ptrdiff_t>(first),
              done.begin() + static_cast<std::ptrdiff_t>(first) + 1);
  std::erase_if(done, [&](const GaussianPart& part) {
    return &part != done.data() && part.opacity < limits.least_opacity;
  });
  if (done.size() > 1 || done[0].covariance_m2 != covariance_m2) {
    for (GaussianPart& part : done) hold_back(part, pieces, limits.most_overhang_m);
  }
  return done;
}

}  // namespace livegs
