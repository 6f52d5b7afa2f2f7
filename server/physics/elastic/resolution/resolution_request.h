// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "physics/elastic/resolution/cell_stiffness.h"
#include "physics/elastic/resolution/lattice_resolution.h"
#include "physics/elastic_body.h"
#include "physics/lattice/lattice.h"

// Requirements of a body on its lattice (lattice_resolution.h), known before the body is created.

namespace livegs {

// Values by material: first the body's own, with a density of mass over volume, then the regions that have a
// material.
struct BodyMaterials {
  std::vector<IsotropicMaterial> elastic;
  std::vector<double> densities_kg_m3, plasticities;
};
BodyMaterials body_materials(const Material& own, std::span<const RegionMaterial> regions, double volume_m3);
// The regions' materials, in order.
std::vector<RegionMaterial> region_materials(std::span<const BodyRegion> regions);

// Uses the fastest wave speed of all materials and the largest Poisson's ratio. `boundary_moved`: the whole
// boundary has a prescribed motion.
ResolutionRequest resolution_request(const BodyExtent& extent, const BodyMaterials& materials,
                                     bool boundary_moved, double rate_hz, int substeps);
// Request of a description, including its cell width if given. Preconditions: those of measure_extent.
ResolutionRequest resolution_request(const ElasticBodyDescription& description, double rate_hz, int substeps);

}  // namespace livegs
