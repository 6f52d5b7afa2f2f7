// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "physics/elastic/resolution/cell_stiffness.h"
#include "physics/elastic/resolution/lattice_resolution.h"

namespace livegs {
namespace {

constexpr double kMinExactPerBulk = 0.9;
// Half-width of the predicted exact range. With the measurement error, exact bodies are within 5 %
// (tests/accuracy/tension_test.cpp).
constexpr double kExactWithin = 0.04;
// Range of the apparent modulus above the ceiling, relative to the ceiling. Far above it the body shows less
// than just above it.
constexpr double kMinCeilingRatio = 0.45, kMaxCeilingRatio = 1.1;
// In short bodies the upper bound is larger by this value over the number of cells along.
constexpr double kEndsOverCeiling = 4.5;
// Below these cell counts, and above this end excess, loads at the ends prevent equilibrium: no prediction is
// possible.
constexpr double kMinBlockCells = 4.5, kMinRowCells = 3.5, kMaxRowWidth = 1.5, kMaxRestingEndExcess = 0.25,
                 kMaxEndCorrection = 0.5;

// Bounds of E_app / E against Ybar. Softness is from a prototype of this solver, with its Courant numbers
// converted to Ybar by the thickness; modulus_band_test.cpp lists the figures. Stiffness is from this solver,
// which is stiffer than the prototype beyond the exact range.
struct Point {
  double y, ratio;
};
template <size_t kCount>
double interpolate(const std::array<Point, kCount>& points, double y) {
  if (y <= points.front().y) return points.front().ratio;
  for (size_t i = 1; i < kCount; ++i) {
    if (y > points[i].y) continue;
    const double s = (y - points[i - 1].y) / (points[i].y - points[i - 1].y);
    return points[i - 1].ratio + s * (points[i].ratio - points[i - 1].ratio);
  }
  return points.back().ratio;
}

// Lower bounds: up to nu = 0.3, from the least Ybar of a band to that of an exact body; and at nu = 0.45.
constexpr std::array<Point, 4> kSoftest30 = {{{1.1, 0.84}, {1.39, 0.88}, {2.17, 0.965}, {4.0, 0.97}}};
constexpr std::array<Point, 5> kSoftest45 = {
    {{1.1, 0.79}, {1.39, 0.82}, {2.17, 0.91}, {3.1, 0.95}, {6.7, 0.98}}};
// Upper bounds: one cell across, two, and four or more.
constexpr std::array<Point, 3> kStiffest1 = {{{1.1, 2.2}, {2.0, 1.5}, {4.5, 1.1}}};
constexpr std::array<Point, 4> kStiffest2 = {{{1.1, 2.1}, {2.0, 1.35}, {3.0, 1.2}, {4.0, 1.08}}};
constexpr std::array<Point, 4> kStiffest4 = {{{1.1, 1.7}, {2.0, 1.4}, {3.0, 1.12}, {4.0, 1.06}}};

double softest(double y, double poisson_ratio) {
  if (poisson_ratio >= 0.45) return interpolate(kSoftest45, y * (1.0 - 2.0 * poisson_ratio) / 0.1);
  const double share = std::clamp((poisson_ratio - 0.3) / 0.15, 0.0, 1.0);
  return (1.0 - share) * interpolate(kSoftest30, y) + share * interpolate(kSoftest45, y);
}

double stiffest(double y, double cells_across) {
  const double one = interpolate(kStiffest1, y), two = interpolate(kStiffest2, y),
               four = interpolate(kStiffest4, y);
  if (cells_across <= 1.0) return one;
  if (cells_across <= 2.0) return one + (cells_across - 1.0) * (two - one);
  return two + std::min(0.5 * (cells_across - 2.0), 1.0) * (four - two);
}

}  // namespace

double mean_pass_compliance(const Lattice& lattice, std::span<const double> inverse_masses_per_kg,
                            double youngs_modulus_pa, double step_s) {
  double volume = 0.0, sum = 0.0;
  for (const LatticeCell& cell : lattice.cells) {
    std::array<double, 8> inverse;
    for (int c = 0; c < 8; ++c) inverse[c] = inverse_masses_per_kg[cell.nodes[c]];
    const double own_mobility = make_cell_block(cell, lattice.cell_width_m, inverse).mobility.trace() / 3.0;
    if (own_mobility <= 0.0) continue;
    volume += cell.volume_m3;
    sum += 1.0 / (youngs_modulus_pa * step_s * step_s * own_mobility);  // V Y
  }
  return volume > 0.0 ? sum / volume : std::numeric_limits<double>::infinity();
}

double thin_part(const Lattice& lattice, bool loose) {
  double thin_m3 = 0.0, all_m3 = 0.0;
  for (const LatticeCell& cell : lattice.cells) {
    all_m3 += cell.volume_m3;
    if (!cell.thin) continue;
    const Eigen::Vector3d& variance = cell.thin->variance_m2;
    const bool sheet = variance[1] * variance[1] > variance[0] * variance[2];
    const double along = cell.thin->axes.col(sheet ? 0 : 2).cwiseAbs().maxCoeff();
    if (loose || along < 0.98) thin_m3 += cell.volume_m3;  // 11 degrees
  }
  return all_m3 > 0.0 ? thin_m3 / all_m3 : 0.0;
}

double modulus_ceiling_pa(const Lattice& lattice, double density_kg_m3, double step_s) {
  const double fullness =
      static_cast<double>(lattice.cells.size()) / static_cast<double>(lattice.node_coordinates.size());
  const double speed_m_s = lattice.cell_width_m / step_s;
  // The factor is 1.85 without compensation. With compensation it depends little on nu.
  return 4.15 * density_kg_m3 * speed_m_s * speed_m_s * fullness;
}

double end_excess(double courant, double cells_along) { return 2.0 * courant * courant / cells_along; }

ModulusBand band_of(const BandRequest& request) {
  const double y = request.mean_pass_compliance, ends = end_excess(request.courant, request.cells_along);
  const double few = request.cells_across < kMaxRowWidth ? kMinRowCells : kMinBlockCells;
  if (request.cells_along < few && ends > kMaxRestingEndExcess) return {ElasticBand::Unknown, 0.0, 0.0};
  if (y < kSoftest30.front().y && request.ceiling_ratio < 1.0) {
    const double most = kMaxCeilingRatio * (1.0 + kEndsOverCeiling / request.cells_along);
    const double most_across = kMaxCeilingRatio * (1.0 + kEndsOverCeiling / request.cells_across);
    return {ElasticBand::Clipped, kMinCeilingRatio * request.ceiling_ratio, most * request.ceiling_ratio,
            most_across * request.ceiling_ratio};
  }
  const double ends_across = end_excess(request.courant, request.cells_across);
  const double across = 1.0 / (1.0 - std::min(ends_across, kMaxEndCorrection));
  if (y > kSoftest30.back().y && y > kMinExactPerBulk / (1.0 - 2.0 * request.poisson_ratio) &&
      ends <= kMaxEndExcess) {
    return {ElasticBand::Exact, 1.0 - kExactWithin, 1.0 + kExactWithin, std::max(across, 1.0 + kExactWithin)};
  }
  const double inside = stiffest(y, request.cells_across);
  return {ElasticBand::Band, softest(y, request.poisson_ratio),
          inside / (1.0 - std::min(ends, kMaxEndCorrection)), inside * across};
}

}  // namespace livegs
