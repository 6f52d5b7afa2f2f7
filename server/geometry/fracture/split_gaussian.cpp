// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/fracture/split_gaussian.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/fracture/truncated_gaussian.h"

namespace livegs {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Maximum number of parts. A Gaussian much larger than the body would have thousands; at the limit, parts are
// flattened instead.
constexpr size_t kMaxParts = 96;
// Spacing of narrower Gaussians, in their standard deviations: their sum has a ripple of 2 exp(-pi²/2), 1.4
// %. They cover kNarrowReach deviations of the original and are at least kMinNarrowing of its width.
constexpr double kNarrowSpacing = 2.0, kNarrowReach = 3.2, kMinNarrowing = 0.2;

// The nearest plane that the ellipsoid of a part crosses.
struct Crossing {
  uint32_t neighbour = ~0u;
  Vector3d normal = Vector3d::UnitX();  // out of the part's cell
  double deviation_m = 0.0;             // standard deviation along the normal
  double end = 0.0;                     // distance of the plane from the mean, in standard deviations
};

CutName cut_name(uint32_t a, uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

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
    const CutName planes = cut_name(part.cell, neighbour);
    if (std::find(part.cuts.begin(), part.cuts.end(), planes) != part.cuts.end()) continue;
    if (one_piece(pieces, part.cell, neighbour)) continue;
    const Crossing crossing = plane_between(part, pieces, neighbour);
    if (crossing.end < nearest.end) nearest = crossing;
  }
  return nearest;
}

// Returns the part of the Gaussian below `end` standard deviations along `normal`.
GaussianPart below(const GaussianPart& part, const Vector3d& normal, double deviation_m, double end) {
  const TruncatedNormal cut = normal_below(end);
  const Vector3d along = part.covariance_m2 * normal / deviation_m;
  GaussianPart half = part;
  half.mean_m += cut.mean * along;
  half.covariance_m2 -= (1.0 - cut.variance) * along * along.transpose();
  half.opacity *= cut.mass / std::sqrt(cut.variance);
  return half;
}

// A Gaussian of variance 1 is the convolution of Gaussians of variance w² and 1 - w². The latter is sampled
// along the normal.
void add_narrower(const GaussianPart& part, const Crossing& crossing, double width, double min_opacity,
                  std::vector<GaussianPart>& out) {
  const Vector3d along = part.covariance_m2 * crossing.normal / crossing.deviation_m;
  const double spread = std::sqrt(1.0 - width * width), spacing = kNarrowSpacing * width;
  const int most = static_cast<int>(kNarrowReach * spread / spacing);
  for (int k = -most; k <= most; ++k) {
    const double at = k * spacing;
    GaussianPart narrow = part;
    narrow.mean_m += at * along;
    narrow.covariance_m2 -= (1.0 - width * width) * along * along.transpose();
    narrow.opacity *= spacing / width / spread * std::exp(-0.5 * at * at / (spread * spread)) /
                      std::sqrt(2.0 * std::numbers::pi);
    narrow.narrowed.push_back(cut_name(part.cell, crossing.neighbour));
    if (narrow.opacity >= min_opacity) out.push_back(std::move(narrow));
  }
}

double overhang_m(const Crossing& crossing) {
  const TruncatedNormal low = normal_below(crossing.end), high = normal_below(-crossing.end);
  return crossing.deviation_m *
         std::max(kSplitDeviations * std::sqrt(low.variance) + low.mean - crossing.end,
                  kSplitDeviations * std::sqrt(high.variance) + high.mean + crossing.end);
}

// Flattens a part that still extends too far because of rounding, cuts of other planes or kMaxParts. Its
// opacity increases accordingly.
void hold_back(GaussianPart& part, const VoronoiPieces& pieces, double max_overhang_m) {
  for (uint32_t neighbour : pieces.cell_neighbours[part.cell]) {
    if (one_piece(pieces, part.cell, neighbour)) continue;
    const Crossing crossing = plane_between(part, pieces, neighbour);
    const double distance_m = crossing.end * crossing.deviation_m;
    const double reach_m = distance_m + max_overhang_m;
    const double share = reach_m / (kSplitDeviations * std::max(crossing.deviation_m, 1e-300));
    if (share >= 1.0) continue;
    const Vector3d along = part.covariance_m2 * crossing.normal / crossing.deviation_m;
    part.covariance_m2 -= (1.0 - share * share) * along * along.transpose();
    part.opacity /= share;
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
    if (crossing.neighbour == ~0u || done.size() + open.size() >= kMaxParts) {
      done.push_back(std::move(part));
      continue;
    }
    const CutName planes = cut_name(part.cell, crossing.neighbour);
    if (crossing.end <= -kSplitDeviations) {  // completely in the neighbour
      part.cell = crossing.neighbour;
      part.cuts.push_back(planes);
      open.push_back(std::move(part));
      continue;
    }
    const GaussianPart high = below(part, -crossing.normal, crossing.deviation_m, -crossing.end);
    const double reach_m = (kSplitDeviations - crossing.end) * crossing.deviation_m;
    if (high.opacity < limits.min_opacity && reach_m <= limits.max_overhang_m) {
      part.cuts.push_back(planes);
      open.push_back(std::move(part));
      continue;
    }
    const double overhang = overhang_m(crossing);
    if (overhang > limits.max_overhang_m &&
        std::find(part.narrowed.begin(), part.narrowed.end(), planes) == part.narrowed.end()) {
      const double width = std::clamp(0.9 * limits.max_overhang_m / crossing.deviation_m, kMinNarrowing, 0.8);
      add_narrower(part, crossing, width, limits.min_opacity, open);
      continue;
    }
    GaussianPart low = below(part, crossing.normal, crossing.deviation_m, crossing.end);
    low.cuts.push_back(planes);
    open.push_back(std::move(low));
    open.push_back(high);
    open.back().cell = crossing.neighbour;
    open.back().cuts.push_back(planes);
  }
  // A cut along one plane may move a mean slightly across another.
  for (GaussianPart& part : done) part.cell = pieces.cell_at(part.mean_m);
  // The largest part in the cell of the mean is first; the others stay in order of creation.
  size_t first = 0;
  double most = -1.0;
  for (size_t k = 0; k < done.size(); ++k) {
    if (done[k].cell == whole.cell && done[k].opacity > most) most = done[k].opacity, first = k;
  }
  if (most < 0.0) {  // all parts are too faint: the original is kept
    done.assign(1, whole);
    first = 0;
  }
  std::rotate(done.begin(), done.begin() + static_cast<std::ptrdiff_t>(first),
              done.begin() + static_cast<std::ptrdiff_t>(first) + 1);
  std::erase_if(done, [&](const GaussianPart& part) {
    return &part != done.data() && part.opacity < limits.min_opacity;
  });
  if (done.size() > 1 || done[0].covariance_m2 != covariance_m2) {
    for (GaussianPart& part : done) hold_back(part, pieces, limits.max_overhang_m);
  }
  return done;
}

}  // namespace livegs
