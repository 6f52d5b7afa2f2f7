// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/elastic/resolution/lattice_resolution.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace livegs {
namespace {

// Minimum cells along the longest side and layers through the thickness of a compact body. Fewer layers make
// torsion too stiff. A sheet or cord needs one layer only, because bending and twisting of a single cell are
// exact.
constexpr double kCellsAlongCompact = 6.0, kLayersCompact = 3.0;
constexpr double kCellsAlongThin = 8.0;
constexpr double kThinRatio = 8.0;
// Minimum cells along the middle side of a thin body, if it is more than one.
constexpr double kMinSplitCells = 1.8;
// Maximum cell width of a thin body, in thicknesses.
constexpr double kMaxWidthOverThickness = 5.0;
// If the node-substep budget is exceeded, the cell width grows by the first factor as long as the second
// number of cells fits along the longest side.
constexpr double kWidthGrowth = 1.2, kMinCellsAlong = 4.0;

// Maximum Courant number of pressure waves during an impact. The sweep must carry the pressure from cell to
// cell, and pressure waves are sqrt((1 - nu) / ((1 + nu)(1 - 2 nu))) times as fast as those in a bar. Above
// about 0.4, nearly incompressible bodies gain energy on landing. kMaxImpactSubsteps bounds the cost.
constexpr double kImpactPressureCourant = 0.3;
constexpr int kMaxImpactSubsteps = 4;

struct Candidate {
  double width_m;
  bool detailed;
  bool split;  // too few cells across the middle side
  int substeps_needed;
  double nodes, cost;
};

int scene_multiple(double needed, int substeps) {
  return substeps * static_cast<int>(std::ceil(std::max(1.0, std::min(needed, 1e6) / substeps) - 1e-9));
}

double limit_of(const ResolutionRequest& request, double width_m) {
  return std::min(courant_limit(request.poisson_ratio, request.size_m.minCoeff() / width_m),
                  request.max_courant);
}

Candidate score(const ResolutionRequest& request, double width_m) {
  const double longest = request.size_m.maxCoeff(), thinnest = request.size_m.minCoeff();
  const bool thin = longest >= kThinRatio * thinnest;
  Candidate candidate{width_m, false, false, 1, 1.0, 0.0};
  // With two layers, one of them nearly empty, the cross-section bends far too easily.
  const double middle =
      request.middle_side_m > 0.0 ? request.middle_side_m : request.size_m.sum() - longest - thinnest;
  candidate.split = thin && middle > (1.0 + 1e-6) * width_m && middle < (kMinSplitCells - 1e-6) * width_m;
  candidate.detailed = !candidate.split &&
                       longest / width_m > (thin ? kCellsAlongThin : kCellsAlongCompact) - 1e-6 &&
                       (thin || thinnest / width_m > kLayersCompact - 1e-6);
  const double wave_m_s = std::sqrt(request.youngs_modulus_pa / request.density_kg_m3);
  const double limit = limit_of(request, width_m);
  candidate.substeps_needed =
      scene_multiple(wave_m_s / (limit * request.rate_hz * width_m), request.substeps);
  for (int d = 0; d < 3; ++d) candidate.nodes *= std::ceil(request.size_m[d] / width_m - 1e-6) + 1.0;
  candidate.cost = candidate.substeps_needed * candidate.nodes;
  return candidate;
}

std::vector<double> candidate_widths(const ResolutionRequest& request) {
  if (request.cell_width_m > 0.0) return {std::max(request.cell_width_m, 0.5 * request.particle_edge_m)};
  const double longest = request.size_m.maxCoeff(), thinnest = request.size_m.minCoeff();
  const double narrowest = 1.5 * request.particle_edge_m * (1.0 - 1e-6);
  std::vector<double> widths;  // from wide to narrow
  // For bodies so long that sixteen cells along are still wider than this.
  if (const double widest = kMaxWidthOverThickness * thinnest; longest > 16.0 * widest && widest >= narrowest)
    widths.push_back(widest);
  for (int along = 6; along <= 16; ++along) {
    const double width = longest / along;
    if (width > thinnest * (1.0 + 1e-6) && width <= kMaxWidthOverThickness * thinnest && width >= narrowest) {
      widths.push_back(width);
    }
  }
  for (int layers = 1; thinnest / layers >= narrowest; ++layers) widths.push_back(thinnest / layers);
  if (widths.empty()) widths.push_back(std::max(thinnest, narrowest));
  return widths;
}

}  // namespace

double courant_limit(double poisson_ratio, double cells_across) {
  // Statics and vibrations are accurate up to 0.75 (0.55 at nu = 0.45), but landing bodies gain energy above
  // 0.6. The limit decreases towards nu = 0.5, because pressure waves get faster: at nu = 0.49 they are 4.1
  // times as fast as those in a bar.
  const double limit = 0.6 - std::max(0.0, poisson_ratio - 0.35) - 7.25 * std::max(0.0, poisson_ratio - 0.45);
  return cells_across < 1.5 ? std::min(limit, 0.5) : limit;
}

LatticeResolution choose_resolution(const ResolutionRequest& request) {
  int cap = std::max(request.substeps, kMaxBodySubsteps / request.substeps * request.substeps);
  if (request.body_substeps > 0) cap = scene_multiple(request.body_substeps, request.substeps);
  std::vector<Candidate> candidates;
  for (const double width : candidate_widths(request)) candidates.push_back(score(request, width));
  const auto costs_too_much = [&](const Candidate& candidate) {
    return candidate.nodes * std::min(candidate.substeps_needed, cap) > request.max_node_substeps;
  };
  const bool over_budget = std::all_of(candidates.begin(), candidates.end(), costs_too_much);
  if (over_budget) {
    const double longest = request.size_m.maxCoeff();
    Candidate wider =
        *std::max_element(candidates.begin(), candidates.end(),
                          [](const Candidate& a, const Candidate& b) { return a.width_m < b.width_m; });
    while (request.cell_width_m <= 0.0 && costs_too_much(wider) &&
           kWidthGrowth * wider.width_m <= longest / kMinCellsAlong) {
      wider = score(request, kWidthGrowth * wider.width_m);
    }
    candidates = {wider};
    if (costs_too_much(wider) && request.body_substeps == 0) {
      const double affordable = std::max(1.0, request.max_node_substeps / wider.nodes / request.substeps);
      cap =
          std::min(cap, static_cast<int>(std::min<double>(affordable, kMaxBodySubsteps)) * request.substeps);
    }
  }
  std::erase_if(candidates,
                [&](const Candidate& candidate) { return !over_budget && costs_too_much(candidate); });

  // Cheapest with enough detail; else the finest that reaches the requested stiffness; else the widest.
  const Candidate* chosen = nullptr;
  for (const Candidate& candidate : candidates) {
    if (candidate.detailed && candidate.substeps_needed <= cap &&
        (!chosen || candidate.cost < chosen->cost)) {
      chosen = &candidate;
    }
  }
  for (const bool split : {false, true}) {
    if (chosen) break;
    for (const Candidate& candidate : candidates) {
      if (candidate.split == split && candidate.substeps_needed <= cap) chosen = &candidate;
    }
  }
  if (!chosen) chosen = &candidates.front();

  LatticeResolution resolution;
  resolution.cell_width_m = chosen->width_m;
  resolution.substeps = request.body_substeps > 0 ? cap : std::min(chosen->substeps_needed, cap);
  resolution.node_substeps = chosen->nodes * resolution.substeps;
  const double reach =
      limit_of(request, chosen->width_m) * request.rate_hz * resolution.substeps * chosen->width_m;
  const double ceiling_pa = request.density_kg_m3 * reach * reach;
  resolution.clipped = chosen->substeps_needed > cap;
  resolution.over_budget =
      over_budget && chosen->width_m > 1.0001 * kMaxWidthOverThickness * request.size_m.minCoeff();
  resolution.youngs_modulus_pa = resolution.clipped ? ceiling_pa : request.youngs_modulus_pa;
  resolution.courant = std::sqrt(resolution.youngs_modulus_pa / request.density_kg_m3) /
                       (request.rate_hz * resolution.substeps * chosen->width_m);
  const double nu = request.poisson_ratio;
  const double pressure_courant =
      resolution.courant * std::sqrt((1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu)));
  resolution.impact_substeps = std::clamp(
      static_cast<int>(std::ceil(pressure_courant / kImpactPressureCourant)), 1, kMaxImpactSubsteps);
  return resolution;
}

}  // namespace livegs
