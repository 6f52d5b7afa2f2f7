// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/elastic/resolution/lattice_resolution.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace livegs {
namespace {

// Minimum cells along the longest side of a compact body; it has half as many layers through its thickness.
// Fewer layers make torsion too stiff. A sheet or cord needs one layer only, because bending and twisting of
// a single cell are exact. A body is thin if kCellsAlongThin of its thickness fit along it.
constexpr double kCellsAlongCompact = 6.0, kCellsAlongThin = 8.0;
// Minimum cells along the middle side of a thin body, if it is more than one.
constexpr double kMinSplitCells = 1.8;
// Maximum cell width of a thin body, in thicknesses.
constexpr double kMaxWidthOverThickness = 5.0;
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
  const bool thin = longest >= kCellsAlongThin * thinnest;
  Candidate candidate{width_m, false, false, 1, 1.0, 0.0};
  // With two layers, one of them nearly empty, the cross-section bends far too easily.
  const double middle =
      request.middle_side_m > 0.0 ? request.middle_side_m : request.size_m.sum() - longest - thinnest;
  candidate.split = thin && middle > (1.0 + 1e-6) * width_m && middle < (kMinSplitCells - 1e-6) * width_m;
  candidate.detailed = !candidate.split &&
                       longest / width_m > (thin ? kCellsAlongThin : kCellsAlongCompact) - 1e-6 &&
                       (thin || thinnest / width_m > kCellsAlongCompact / 2.0 - 1e-6);
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
  return cells_across < 1.5 ? std::min(limit, kMaxThinCourant) : limit;
}

BodyMaterials body_materials(const Material& own, std::span<const RegionMaterial> regions, double volume_m3) {
  BodyMaterials materials;
  const auto add = [&](double youngs, double poisson, double density, double plasticity) {
    materials.elastic.push_back({youngs, poisson});
    materials.densities_kg_m3.push_back(density);
    materials.plasticities.push_back(plasticity);
  };
  const double own_density = own.mass_kg / volume_m3;
  add(own.effective_youngs_modulus_pa(), own.poisson_ratio, own_density, own.plasticity);
  for (const RegionMaterial& region : regions) {
    add(region.youngs_modulus_pa.value_or(region.youngs_modulus_factor * own.effective_youngs_modulus_pa()),
        region.poisson_ratio.value_or(own.poisson_ratio),
        region.density_kg_m3.value_or(region.density_factor * own_density),
        region.plasticity.value_or(own.plasticity));
  }
  return materials;
}

ResolutionRequest resolution_request(const BodyExtent& extent, const BodyMaterials& materials,
                                     bool boundary_moved, double rate_hz, int substeps) {
  size_t fastest = 0;
  const auto speed_squared = [&](size_t k) {
    return materials.elastic[k].youngs_modulus_pa / materials.densities_kg_m3[k];
  };
  for (size_t k = 1; k < materials.elastic.size(); ++k) {
    if (speed_squared(k) > speed_squared(fastest)) fastest = k;
  }
  ResolutionRequest request;
  // If voxels do not fill a body thinner than the cubes of its particles, its size includes those cubes.
  // Otherwise many narrow cells would be chosen for a sheet, which gains energy when it lands on its edge; a
  // sheet bends correctly in wide cells.
  request.size_m = extent.max_m - extent.min_m;
  request.middle_side_m = request.size_m.sum() - request.size_m.maxCoeff() - request.size_m.minCoeff();
  const bool by_voxels = extent.box_edge_m == extent.spacing_m;
  if (!by_voxels && request.size_m.minCoeff() < 0.999 * extent.box_edge_m)
    request.size_m.array() += extent.box_edge_m;
  request.particle_edge_m = extent.box_edge_m;
  request.youngs_modulus_pa = materials.elastic[fastest].youngs_modulus_pa;
  request.density_kg_m3 = materials.densities_kg_m3[fastest];
  for (const IsotropicMaterial& one : materials.elastic) {
    request.poisson_ratio = std::max(request.poisson_ratio, one.poisson_ratio);
  }
  request.rate_hz = rate_hz;
  request.substeps = substeps;
  if (boundary_moved) request.max_courant = kBoundaryCourant;
  if (extent.loose) request.max_courant = std::min(request.max_courant, kMaxThinCourant);
  return request;
}

ResolutionRequest resolution_request(const ElasticBodyDescription& description, double rate_hz,
                                     int substeps) {
  const std::vector<double>& volumes_m3 = description.particles.volumes_m3;
  std::vector<RegionMaterial> regions;
  bool boundary_moved = false;
  for (const BodyRegion& region : description.regions) {
    if (region.material) regions.push_back(*region.material);
    boundary_moved = boundary_moved || (region.boundary && region.motion);
  }
  const BodyMaterials materials = body_materials(description.material, regions,
                                                 std::accumulate(volumes_m3.begin(), volumes_m3.end(), 0.0));
  ResolutionRequest request =
      resolution_request(measure_extent(description.particles), materials, boundary_moved, rate_hz, substeps);
  request.cell_width_m = description.cell_width_m;
  request.body_substeps = description.substeps;
  return request;
}

LatticeResolution choose_resolution(const ResolutionRequest& request) {
  int cap = std::max(request.substeps, kMaxBodySubsteps / request.substeps * request.substeps);
  if (request.body_substeps > 0) cap = scene_multiple(request.body_substeps, request.substeps);
  std::vector<Candidate> candidates;
  for (const double width : candidate_widths(request)) candidates.push_back(score(request, width));
  const auto costs_too_much = [&](const Candidate& candidate) {
    return candidate.nodes * std::min(candidate.substeps_needed, cap) > request.max_node_substeps;
  };
  const bool over_budget = std::ranges::all_of(candidates, costs_too_much);
  if (over_budget) {
    const double longest = request.size_m.maxCoeff();
    Candidate wider = std::ranges::max(candidates, {}, &Candidate::width_m);
    // The width grows in steps of a fifth as long as half of the cells of a thin body fit along the body.
    while (request.cell_width_m <= 0.0 && costs_too_much(wider) &&
           1.2 * wider.width_m <= longest / (kCellsAlongThin / 2.0)) {
      wider = score(request, 1.2 * wider.width_m);
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
