// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/rigid_in_disguise.h"

#include <numeric>

#include "physics/cell_choice.h"
#include "physics/lattice.h"

namespace livegs {

std::optional<std::string> rigid_in_disguise(const ElasticBodyDescription& body, double rate_hz,
                                             int substeps) {
  const std::vector<double>& volumes_m3 = body.particles.volumes_m3;
  const double volume_m3 = std::accumulate(volumes_m3.begin(), volumes_m3.end(), 0.0);
  if (body.particles.positions_m.empty() || !(volume_m3 > 0.0)) return std::nullopt;
  const BodyExtent extent = measure_extent(body.particles);
  CellDemand demand;
  demand.size_m = extent.max_m - extent.min_m;
  demand.particle_edge_m = extent.box_edge_m;
  demand.youngs_modulus_pa = body.material.effective_youngs_modulus_pa();
  demand.poisson_ratio = body.material.poisson_ratio;
  demand.density_kg_m3 = body.material.mass_kg / volume_m3;
  demand.rate_hz = rate_hz;
  demand.substeps = substeps;
  const double reached_pa = choose_cells(demand).youngs_modulus_pa;
  if (!(demand.youngs_modulus_pa > kStiffestOverReached * reached_pa)) return std::nullopt;
  char reason[160];
  std::snprintf(reason, sizeof reason,
                "E* = %.3g Pa is %.0f times what its cells can reach at %g Hz (%.3g Pa): rigid",
                demand.youngs_modulus_pa, demand.youngs_modulus_pa / reached_pa, rate_hz, reached_pa);
  return reason;
}

}  // namespace livegs
