// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/tension.h"

#include <cmath>

#include "study/block.h"
#include "study/particle_fit.h"
#include "study/quasi_static.h"
#include "study/uniaxial.h"

namespace livegs::study {

Result<Outcome> tension(const Setup& setup) {
  ElasticBodyDescription bar = describe_bar(setup);
  bar.material.loss_factor = 2.0;
  auto made = Stage::make(setup, bar);
  if (!made) return made.error();
  Stage& stage = *made;

  // A body that says it is softer is pulled less, so that strains stay small.
  const double softness = predicted_softness(setup, stage.body());
  if (softness < 1.0) damp(stage, softness);
  const double stress_pa = 0.005 * softness * setup.youngs_modulus_pa;
  const int across = points_across(setup, stage.body(), kBarWidth_m);
  const auto pull = [&](double share) {
    stage.forces.clear();
    add_traction(stage.forces, 0.5 * kBarLength_m, kBarWidth_m, {share * stress_pa, 0, 0}, across);
    add_traction(stage.forces, -0.5 * kBarLength_m, kBarWidth_m, {-share * stress_pa, 0, 0}, across);
  };
  const RestBox middle{{-0.25 * kBarLength_m, -1, -1}, {0.25 * kBarLength_m, 1, 1}};
  const auto strains = [&]() -> Eigen::Vector2d {
    const Eigen::Matrix3d f = mean_deformation(stage.body(), stage.rest(), middle);
    return {f.col(0).norm() - 1.0, 0.5 * (f.col(1).norm() + f.col(2).norm()) - 1.0};
  };
  // Free ends swing with a period of 2 L / c.
  const double wave_m_s = std::sqrt(softness * setup.youngs_modulus_pa / setup.density_kg_m3);
  const Eigen::Vector2d strain = load_slowly(stage, {pull, strains, 2 * kBarLength_m / wave_m_s});
  if (setup.engine != Engine::Bullet) stage.charge_unforced();

  const Uniaxial exact = stretched_by(setup.youngs_modulus_pa, setup.poisson_ratio, stress_pa);
  return stage.finish({relative("youngs_modulus", (exact.along - 1.0) / strain[0], 1.0, 0.05),
                       absolute("poisson_ratio", -strain[1] / strain[0], (1.0 - exact.across) / (exact.along - 1.0),
                                0.02)});
}

}  // namespace livegs::study
