// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/elastic_scenes/cantilever.h"

#include <algorithm>
#include <cmath>

#include "study/harness/block.h"
#include "study/harness/quasi_static.h"

namespace livegs::study {

double timoshenko_sag_m(double youngs_modulus_pa, double poisson_ratio, double weight_n_m3) {
  const double length2 = kBarLength_m * kBarLength_m, width2 = kBarWidth_m * kBarWidth_m;
  const double bending = weight_n_m3 * length2 * length2 / (8 * youngs_modulus_pa * width2 / 12);
  const double shear_modulus_pa = 0.5 * youngs_modulus_pa / (1 + poisson_ratio);
  return bending + weight_n_m3 * length2 / (2 * (5.0 / 6.0) * shear_modulus_pa);
}

double clamp_stiffening(double poisson_ratio) {
  if (poisson_ratio < 0.15) return 1.0;
  // Extrapolated from 4, 8 and 16 layers (cantilever_reference_test.cpp); at nu 0 they converge to 1.
  return poisson_ratio < 0.375 ? 0.9795 : 0.9515;
}

Result<Outcome> cantilever(const Setup& setup) {
  // The clamped length is at least one cell, and a multiple of cells of 12.5, 25 and 50 mm.
  const double clamp_m = std::max(0.05, setup.cell_width_m), half_m = 0.5 * kBarWidth_m;
  ElasticBodyDescription bar =
      describe_box(setup, {-clamp_m, -half_m, -half_m}, {kBarLength_m, half_m, half_m});
  bar.material.loss_factor = 2.0;
  BodyRegion clamp = fixed_box({-clamp_m - 1, -1, -1}, {0, 1, 1});
  clamp.name = "clamp";
  bar.regions.push_back(clamp);
  auto made = Stage::make(setup, bar);
  if (!made) return made.error();
  Stage& stage = *made;

  const double softness = predicted_softness(setup, stage.body());
  if (softness < 1.0) damp(stage, softness);
  const double sag_m = 0.01 * kBarLength_m * softness;
  const double unit_sag_m = timoshenko_sag_m(setup.youngs_modulus_pa, setup.poisson_ratio, 1.0);
  const double gravity_m_s2 = sag_m / unit_sag_m / setup.density_kg_m3;
  const double wave_m_s = std::sqrt(softness * setup.youngs_modulus_pa / setup.density_kg_m3);
  // The lowest bending mode of a clamped bar.
  const double lowest_rad_s =
      3.516 / std::sqrt(12.0) * kBarWidth_m / (kBarLength_m * kBarLength_m) * wave_m_s;
  const auto weigh = [&](double share) { stage.gravity_m_s2 = {0, -share * gravity_m_s2, 0}; };
  const auto tip = [&]() -> Eigen::Vector2d {
    return {-stage.body().world_point({kBarLength_m, 0, 0}).y(), 0.0};
  };
  const double measured_m = load_quasi_statically(stage, {weigh, tip, 2 * M_PI / lowest_rad_s})[0];
  return stage.finish({relative("deflection", measured_m / sag_m, clamp_stiffening(setup.poisson_ratio),
                                setup.poisson_ratio > 0.0 ? 0.05 : 0.03)});
}

}  // namespace livegs::study
