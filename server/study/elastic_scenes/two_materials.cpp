// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/elastic_scenes/two_materials.h"

#include <cmath>

#include "study/harness/block.h"
#include "study/harness/particle_fit.h"
#include "study/harness/quasi_static.h"
#include "study/harness/uniaxial.h"

namespace livegs::study {

Result<Outcome> two_materials(const Setup& setup, double joint_m) {
  if (setup.engine != Engine::Cells)
    return unsupported("two materials: only the engine cells supports several materials in one body");
  constexpr double kTimesStiffer = 2.0, kEnd_m = 0.5 * kBarLength_m;
  ElasticBodyDescription bar = describe_bar(setup);
  bar.material.loss_factor = 2.0;
  BodyRegion stiff;
  stiff.name = "stiff part";
  stiff.min_m = {joint_m, -1, -1};
  stiff.max_m = {1, 1, 1};
  stiff.material.emplace().youngs_modulus_pa = kTimesStiffer * setup.youngs_modulus_pa;
  bar.regions.push_back(stiff);
  auto made = Stage::make(setup, bar);
  if (!made) return made.error();
  Stage& stage = *made;

  const double stress_pa = 0.005 * setup.youngs_modulus_pa;
  const int across = points_across(setup, stage.body(), kBarWidth_m);
  const auto pull = [&](double share) {
    stage.forces.clear();
    add_traction(stage.forces, kEnd_m, kBarWidth_m, {share * stress_pa, 0, 0}, across);
    add_traction(stage.forces, -kEnd_m, kBarWidth_m, {-share * stress_pa, 0, 0}, across);
  };
  const auto middle_of = [](double from_m, double to_m) {
    const double inset_m = 0.25 * (to_m - from_m);
    return RestBox{{from_m + inset_m, -1, -1}, {to_m - inset_m, 1, 1}};
  };
  const auto strain_of = [&](const RestBox& part) {
    return mean_deformation(stage.body(), stage.rest(), part).col(0).norm() - 1.0;
  };
  const auto strains = [&]() -> Eigen::Vector2d {
    return {strain_of(middle_of(-kEnd_m, joint_m)), strain_of(middle_of(joint_m, kEnd_m))};
  };
  const double wave_m_s = std::sqrt(setup.youngs_modulus_pa / setup.density_kg_m3);
  const Eigen::Vector2d strain = load_quasi_statically(stage, {pull, strains, 2 * kBarLength_m / wave_m_s});
  const double soft = stretched_by(setup.youngs_modulus_pa, setup.poisson_ratio, stress_pa).along - 1.0;
  const double hard =
      stretched_by(kTimesStiffer * setup.youngs_modulus_pa, setup.poisson_ratio, stress_pa).along - 1.0;
  return stage.finish(
      {relative("soft_strain", strain[0], soft, 0.1), relative("stiff_strain", strain[1], hard, 0.1)});
}

}  // namespace livegs::study
