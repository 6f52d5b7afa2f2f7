// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "physics/elastic/resolution/cell_stiffness.h"
#include "physics/elastic/resolution/lattice_resolution.h"
#include "physics/elastic_body.h"
#include "physics/lattice/lattice.h"

// What a body asks of its lattice (cell_choice.h), known before it is made.

namespace livegs {

// By material: the body's own first, whose density is its mass over its volume, then those of its regions
// that have one.
struct BodyMaterials {
  std::vector<IsotropicMaterial> elastic;
  std::vector<double> densities_kg_m3, plasticities;
};
BodyMaterials body_materials(const Material& own, std::span<const RegionMaterial> regions, double volume_m3);
// The regions' materials, in their order.
std::vector<RegionMaterial> region_materials(std::span<const BodyRegion> regions);

// Of the fastest wave among the materials and the largest Poisson's ratio. `boundary_moved`: all of its
// outside is.
ResolutionRequest resolution_request(const BodyExtent& extent, const BodyMaterials& materials,
                                     bool boundary_moved, double rate_hz, int substeps);
// Of a described body, with the cells it was given, if any. Preconditions: those of measure_extent.
ResolutionRequest resolution_request(const ElasticBodyDescription& description, double rate_hz, int substeps);

}  // namespace livegs
