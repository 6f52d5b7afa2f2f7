// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/elastic/resolution/resolution_request.h"

#include <algorithm>
#include <numeric>

namespace livegs {

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

std::vector<RegionMaterial> region_materials(std::span<const BodyRegion> regions) {
  std::vector<RegionMaterial> materials;
  for (const BodyRegion& region : regions) {
    if (region.material) materials.push_back(*region.material);
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
  return request;
}

ResolutionRequest resolution_request(const ElasticBodyDescription& description, double rate_hz,
                                     int substeps) {
  const std::vector<double>& volumes_m3 = description.particles.volumes_m3;
  const BodyMaterials materials = body_materials(description.material, region_materials(description.regions),
                                                 std::accumulate(volumes_m3.begin(), volumes_m3.end(), 0.0));
  const bool boundary_moved =
      std::any_of(description.regions.begin(), description.regions.end(),
                  [](const BodyRegion& region) { return region.boundary && region.motion; });
  ResolutionRequest request =
      resolution_request(measure_extent(description.particles), materials, boundary_moved, rate_hz, substeps);
  request.cell_width_m = description.cell_width_m;
  request.body_substeps = description.substeps;
  return request;
}

}  // namespace livegs
