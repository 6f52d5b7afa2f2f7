// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/harness/block.h"

namespace livegs::study {

using Eigen::Vector3d;

ParticleSet fill_box(const Vector3d& min_m, const Vector3d& max_m, double spacing_m) {
  ParticleSet set;
  set.spacing_m = spacing_m;
  const Eigen::Vector3i n = ((max_m - min_m) / spacing_m).array().round().cast<int>();
  for (int k = 0; k < n.z(); ++k) {
    for (int j = 0; j < n.y(); ++j) {
      for (int i = 0; i < n.x(); ++i)
        set.positions_m.push_back(min_m + spacing_m * Vector3d(i + 0.5, j + 0.5, k + 0.5));
    }
  }
  set.volumes_m3.assign(set.positions_m.size(), spacing_m * spacing_m * spacing_m);
  set.on_surface.assign(set.positions_m.size(), false);
  return set;
}

ElasticBodyDescription describe_box(const Setup& setup, const Vector3d& min_m, const Vector3d& max_m) {
  ElasticBodyDescription description;
  description.particles = fill_box(min_m, max_m, setup.spacing_m);
  Material& material = description.material;
  material.behavior = Behavior::Elastic;
  material.mass_kg = setup.density_kg_m3 * (max_m - min_m).prod();
  material.youngs_modulus_pa = setup.youngs_modulus_pa;
  material.poisson_ratio = setup.poisson_ratio;
  material.loss_factor = 0.0;
  material.friction = 0.0;
  description.cell_width_m = setup.cell_width_m;
  return description;
}

ElasticBodyDescription describe_bar(const Setup& setup) {
  const Vector3d half(0.5 * kBarLength_m, 0.5 * kBarWidth_m, 0.5 * kBarWidth_m);
  return describe_box(setup, -half, half);
}

}  // namespace livegs::study
