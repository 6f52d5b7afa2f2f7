// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/harness/affine_ramp.h"

#include <algorithm>
#include <cmath>

#include "study/harness/block.h"
#include "study/harness/stage.h"

namespace livegs::study {

Result<Outcome> affine_ramp(const Setup& setup, const Eigen::Matrix3d& matrix) {
  if (setup.engine == Engine::Bullet) return unsupported("bullet: prescribed motions are not supported");
  const Eigen::Vector3d half = Eigen::Vector3d::Constant(0.1);
  ElasticBodyDescription block = describe_box(setup, -half, half);
  block.material.loss_factor = 2.0;
  const double crossing_s = 2 * half.x() / std::sqrt(setup.youngs_modulus_pa / setup.density_kg_m3);
  AffineRamp ramp;
  ramp.matrix = matrix;
  ramp.end_s = std::max(10 * crossing_s, 12 / setup.rate_hz);
  BodyRegion boundary;
  boundary.name = "boundary";
  boundary.boundary = true;
  boundary.motion = ramp;
  block.regions.push_back(boundary);
  auto made = Stage::make(setup, block);
  if (!made) return made.error();
  Stage& stage = *made;

  stage.run(ramp.end_s + 20 * crossing_s);
  const double inside_m = half.x() - stage.body().accuracy().cell_width_m;
  const std::vector<ParticleState> now = stage.body().particles();
  double worst = 0.0;
  for (size_t i = 0; i < now.size(); ++i) {
    if (stage.rest().positions_m[i].cwiseAbs().maxCoeff() > inside_m) continue;
    worst = std::max(worst, (now[i].deformation_gradient - matrix).norm() / matrix.norm());
  }
  return stage.finish({absolute("interior", worst, 0.0, 0.02)});
}

}  // namespace livegs::study
