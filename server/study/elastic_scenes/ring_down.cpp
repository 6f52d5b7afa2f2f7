// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/elastic_scenes/ring_down.h"

#include <algorithm>
#include <cmath>

#include "study/harness/block.h"
#include "study/harness/stage.h"

namespace livegs::study {

Result<Outcome> ring_down(const Setup& setup) {
  ElasticBodyDescription bar = describe_bar(setup);
  bar.initial_deformation(0, 0) = 1.005;
  auto made = Stage::make(setup, bar);
  if (!made) return made.error();
  Stage& stage = *made;

  const double frequency_hz = std::sqrt(setup.youngs_modulus_pa / setup.density_kg_m3) / (2 * kBarLength_m);
  const double rad_s = 2 * M_PI * frequency_hz;
  // Displacement and velocity of the mode sin(pi x / L), in the same unit.
  const auto mode = [&]() -> Eigen::Vector2d {
    Eigen::Vector2d q = Eigen::Vector2d::Zero();
    const std::vector<ParticleState> now = stage.body().particles();
    for (size_t i = 0; i < now.size(); ++i) {
      const double x = stage.rest().positions_m[i].x(), shape = std::sin(M_PI * x / kBarLength_m);
      q += shape * Eigen::Vector2d(now[i].position_m.x() - x, now[i].velocity_m_s.x() / rad_s);
    }
    return q;
  };
  // The phase rotates once per period. It is followed for 5.25 rotations, or for four times the expected
  // time.
  const double start = mode()[0];
  double phase = 0.0, phase_s = 0.0, amplitude = 0.0;
  int amplitudes = 0;
  const auto watch = [&] {
    const Eigen::Vector2d q = mode();
    double turned = std::remainder(std::atan2(-q[1], q[0]) - phase, 2 * M_PI);
    phase += turned;
    phase_s = stage.time_s();
    if (std::abs(phase) > 4.75 * 2 * M_PI) {
      amplitude += q.norm();
      ++amplitudes;
    }
  };
  const int every = stage.sampling_interval(1.0 / frequency_hz);
  while (std::abs(phase) < 5.25 * 2 * M_PI && stage.time_s() * frequency_hz < 21.0 && std::isfinite(phase)) {
    stage.run(stage.frame_s(), nullptr, watch, every);
  }
  // If five periods were not completed, the amplitude at the end counts.
  const double left = amplitudes > 0 ? amplitude / amplitudes / start : mode().norm() / start;
  return stage.finish({relative("frequency", std::abs(phase) / (2 * M_PI * phase_s), frequency_hz, 0.01),
                       absolute("amplitude", left, 1.0, 0.1)});
}

}  // namespace livegs::study
