// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>

#include "scenes/elastic_bodies.h"
#include "scenes/thin_bodies.h"

// A free quarter cylinder of radius 0.1 m, 3 mm thick and 50 mm wide.

namespace livegs::test {

inline const Strip kQuarter{0.1 * M_PI / 2, 0.05, 0.1};
inline constexpr double kQuarterModulus_pa = 2e4;  // cells of 3 thicknesses reach it in 16 substeps

// `cells_t` is the cell width in thicknesses. Plain cells if `thin` is false (CellsOptions::thin).
inline ElasticBodyDescription describe_quarter(double cells_t, double poisson_ratio, bool thin) {
  ParticleSet set;
  set.spacing_m = kStripThickness_m;
  for (const StripPoint& point : strip_points(kQuarter)) {
    set.positions_m.push_back(point.at_m);
    set.volumes_m3.push_back(point.volume_m3);
    set.on_surface.push_back(true);
  }
  ElasticBodyDescription description = describe(std::move(set), kQuarterModulus_pa, poisson_ratio,
                                                cells_t * kStripThickness_m, kStripDensity_kg_m3);
  description.material.loss_factor = 1.0;
  description.cells.thin = thin;
  return description;
}

}  // namespace livegs::test
