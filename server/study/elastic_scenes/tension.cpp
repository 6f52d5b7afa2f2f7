// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/elastic_scenes/tension.h"

#include <cmath>
#include <functional>

#include "study/harness/block.h"
#include "study/harness/particle_fit.h"
#include "study/harness/quasi_static.h"
#include "study/harness/uniaxial.h"

namespace livegs::study {

namespace {

// Stretch along and across.
using Stretches = std::function<Eigen::Vector2d(const Stage& stage)>;

Result<Outcome> pulled(const Setup& setup, double length_m, double width_m, const Stretches& stretches) {
  const Eigen::Vector3d half_m(0.5 * length_m, 0.5 * width_m, 0.5 * width_m);
  ElasticBodyDescription bar = describe_box(setup, -half_m, half_m);
  bar.material.loss_factor = 2.0;
  auto made = Stage::make(setup, bar);
  if (!made) return made.error();
  Stage& stage = *made;

  // A body with a reported lower stiffness is pulled less, so that strains stay small.
  const double softness = predicted_softness(setup, stage.body());
  if (softness < 1.0) damp(stage, softness);
  const double stress_pa = 0.005 * softness * setup.youngs_modulus_pa;
  const int across = points_across(setup, stage.body(), width_m);
  const auto pull = [&](double share) {
    stage.forces.clear();
    add_traction(stage.forces, half_m.x(), width_m, {share * stress_pa, 0, 0}, across);
    add_traction(stage.forces, -half_m.x(), width_m, {-share * stress_pa, 0, 0}, across);
  };
  const auto strains = [&]() -> Eigen::Vector2d { return stretches(stage).array() - 1.0; };
  // Free ends vibrate with a period of 2 L / c.
  const double wave_m_s = std::sqrt(softness * setup.youngs_modulus_pa / setup.density_kg_m3);
  const Eigen::Vector2d strain = load_quasi_statically(stage, {pull, strains, 2 * length_m / wave_m_s});
  if (setup.engine != Engine::Bullet) stage.measure_unforced_cost();

  const Uniaxial exact = stretched_by(setup.youngs_modulus_pa, setup.poisson_ratio, stress_pa);
  return stage.finish(
      {relative("youngs_modulus", (exact.along - 1.0) / strain[0], 1.0, 0.05),
       absolute("poisson_ratio", -strain[1] / strain[0], (1.0 - exact.across) / (exact.along - 1.0), 0.02)});
}

}  // namespace

Result<Outcome> tension(const Setup& setup) {
  const RestBox middle{{-0.25 * kBarLength_m, -1, -1}, {0.25 * kBarLength_m, 1, 1}};
  return pulled(setup, kBarLength_m, kBarWidth_m, [&](const Stage& stage) -> Eigen::Vector2d {
    const Eigen::Matrix3d f = mean_deformation(stage.body(), stage.rest(), middle);
    return {f.col(0).norm(), 0.5 * (f.col(1).norm() + f.col(2).norm())};
  });
}

Result<Outcome> tension_of_block(const Setup& setup, double length_m, double width_m) {
  return pulled(setup, length_m, width_m, [](const Stage& stage) -> Eigen::Vector2d {
    const Eigen::Vector3d stretches = face_to_face(stage.body(), stage.rest());
    return {stretches.x(), 0.5 * (stretches.y() + stretches.z())};
  });
}

}  // namespace livegs::study
