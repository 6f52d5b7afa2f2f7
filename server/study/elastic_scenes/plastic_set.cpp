// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/elastic_scenes/plastic_set.h"

#include <Eigen/LU>
#include <cmath>

#include "physics/material/return_mapping.h"
#include "study/harness/block.h"
#include "study/harness/particle_fit.h"
#include "study/harness/stage.h"

namespace livegs::study {

double set_of_stretch(double stretch, double yield, double poisson_ratio) {
  const double radius = yield_surface(1.0 - yield, poisson_ratio).radius;
  double low = 1.0, high = stretch;
  for (int i = 0; i < 60; ++i) {
    const double d = 0.5 * (low + high);
    const double strain = (stretch - d) + (1 / std::sqrt(d) - 1 / std::sqrt(stretch));
    (std::sqrt(2.0 / 3.0) * strain > radius ? low : high) = d;
  }
  return 0.5 * (low + high) - 1.0;
}

namespace {

// Stretches the block to twice its yield strain along x and to `across` in y and z, holds and releases it.
// `set` is the expected plastic strain.
Result<Outcome> stretched(const Setup& setup, double speed, double yield, double across, double set) {
  if (setup.engine == Engine::Bullet) return unsupported("bullet: deformable bodies have no plasticity");
  const Eigen::Vector3d half(kBarWidth_m, 0.5 * kBarWidth_m, 0.5 * kBarWidth_m);
  ElasticBodyDescription block = describe_box(setup, -half, half);
  block.material.plasticity = 1.0 - yield;
  block.material.loss_factor = 1.0;
  const double period_s = 4 * half.x() / std::sqrt(setup.youngs_modulus_pa / setup.density_kg_m3);
  const double ramp_s = 40 * period_s / speed;
  AffineRamp stretch;
  stretch.matrix.diagonal() = Eigen::Vector3d(1 + 2 * yield, across, across);
  stretch.end_s = ramp_s;
  BodyRegion boundary;
  boundary.name = "boundary";
  boundary.boundary = true;
  boundary.motion = stretch;
  block.regions.push_back(boundary);
  auto made = Stage::make(setup, block);
  if (!made) return made.error();
  Stage& stage = *made;

  stage.run(ramp_s + 8 * period_s);
  stage.body().release_region("boundary");
  stage.run(20 * period_s);
  const Eigen::Matrix3d left = mean_deformation(stage.body(), stage.rest(), {-half, half});
  return stage.finish({relative("set", left.col(0).norm() - 1.0, set, 0.02),
                       absolute("volume_ratio", left.determinant(), 1.0, 1e-3)});
}

}  // namespace

Result<Outcome> plastic_set(const Setup& setup, double speed) {
  constexpr double kPlasticity = 0.9, kYield = 1.0 - kPlasticity, kStretch = 1.0 + 2 * kYield;
  return stretched(setup, speed, kYield, 1 / std::sqrt(kStretch),
                   set_of_stretch(kStretch, kYield, setup.poisson_ratio));
}

Result<Outcome> plastic_set_in_tension(const Setup& setup, double speed, double yield) {
  // The sides are free; by the energy of return_mapping.h: b - s + lambda / 2 mu (l b² - 1) l b = 0, with s
  // the plastic stretch across.
  const double length = 1.0 + 2.0 * yield, side = 1.0 / std::sqrt(1.0 + yield);
  const double ratio = setup.poisson_ratio / (1.0 - 2.0 * setup.poisson_ratio);
  double low = 0.5, high = 1.0;
  for (int i = 0; i < 60; ++i) {
    const double b = 0.5 * (low + high);
    (b - side + ratio * (length * b * b - 1.0) * length * b < 0.0 ? low : high) = b;
  }
  return stretched(setup, speed, yield, 0.5 * (low + high), yield);
}

}  // namespace livegs::study
