// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/elastic_scenes/squash.h"

#include <Eigen/LU>
#include <cmath>

#include "study/harness/block.h"
#include "study/harness/particle_fit.h"
#include "study/harness/quasi_static.h"
#include "study/harness/uniaxial.h"

namespace livegs::study {

Result<Outcome> squash(const Setup& given) {
  Setup setup = given;
  // Plates contact one point per voxel face; with equal numbers of voxels and cells, nodes between the points
  // would penetrate.
  if (setup.engine == Engine::Cells && setup.cell_width_m > 0.0) setup.spacing_m = 0.5 * setup.cell_width_m;
  if (setup.engine == Engine::Bullet) return unsupported("bullet: plates are not supported");
  constexpr double kEdge_m = 0.1, kAlong = 0.7;
  const Eigen::Vector3d half = Eigen::Vector3d::Constant(0.5 * kEdge_m);
  ElasticBodyDescription block = describe_box(setup, -half, half);
  block.material.loss_factor = 2.0;
  auto made = Stage::make(setup, block);
  if (!made) return made.error();
  Stage& stage = *made;

  Collider floor, ceiling;
  floor.shape = ceiling.shape = PlaneShape{};
  floor.friction = ceiling.friction = 0.0;
  ceiling.world_from_collider.orientation = Eigen::Quaterniond(0, 1, 0, 0);  // half a turn about x
  const auto press = [&](double share) {
    const double height_m = 0.5 * kEdge_m * (1.0 - (1.0 - kAlong) * share);
    floor.world_from_collider.position_m = {0, -height_m, 0};
    ceiling.world_from_collider.position_m = {0, height_m, 0};
    stage.colliders = {floor, ceiling};
  };
  const RestBox all{-half, half};
  const auto volume = [&]() -> Eigen::Vector2d {
    return {mean_deformation(stage.body(), stage.rest(), all).determinant(), 0.0};
  };
  // Slow compared with the block's own vibration: 4 edges divided by the wave speed.
  const double softness = predicted_softness(setup, stage.body());
  if (softness < 1.0) damp(stage, softness);
  const double wave_m_s = std::sqrt(softness * setup.youngs_modulus_pa / setup.density_kg_m3);
  const double ratio = load_quasi_statically(stage, {press, volume, 4 * kEdge_m / wave_m_s})[0];
  return stage.finish(
      {relative("volume_ratio", ratio, stretched_to(setup.poisson_ratio, kAlong).volume_ratio(), 0.01)});
}

}  // namespace livegs::study
