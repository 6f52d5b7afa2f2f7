// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <limits>

#include "study/harness/rigid_scenes.h"
#include "study/harness/rigid_stage.h"

namespace livegs::study {
namespace {

using Eigen::Vector3d;

constexpr double kArm_m = 1.0, kBobRadius_m = 0.05;
constexpr double kInertia_m2 =
    kArm_m * kArm_m + 0.4 * kBobRadius_m * kBobRadius_m;  // of 1 kg about the pivot

}  // namespace

double ball_pendulum_period_s(double amplitude_rad) {
  // 2 K(k) / pi = 1 / agm(1, cos(theta0 / 2)) with k = sin(theta0 / 2).
  double a = 1.0, b = std::cos(0.5 * amplitude_rad);
  for (int i = 0; i < 8; ++i) {
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
  }
  return 2 * M_PI * std::sqrt(kInertia_m2 / (kGravity_m_s2 * kArm_m)) / a;
}

Result<RigidOutcome> ball_pendulum(const RigidSetup& setup) {
  auto made = RigidStage::make(setup);
  if (!made) return made.error();
  RigidStage& stage = *made;
  const double amplitude_rad = setup.parameter * M_PI / 180;
  RigidPart ball;
  ball.radius_m = kBobRadius_m;
  ball.world_from_part.position_m = kArm_m * Vector3d(std::sin(amplitude_rad), -std::cos(amplitude_rad), 0);
  stage.add(ball);
  if (auto joined = stage.solver().join(0, std::nullopt, Vector3d::Zero()); !joined) return joined.error();

  double before = amplitude_rad, first_s = -1.0, last_s = 0.0;
  int crossings = 0;
  stage.run(10.0, [&] {
    const Vector3d& at = stage.motions()[0].world_from_part.position_m;
    const double now = std::atan2(at.x(), -at.y());
    if ((before < 0.0) != (now < 0.0)) {
      last_s = stage.time_s() - stage.frame_s() * now / (now - before);
      if (first_s < 0.0)
        first_s = last_s;
      else
        ++crossings;
    }
    before = now;
  });
  const RigidMotion& end = stage.motions()[0];
  const double period_s =
      crossings > 0 ? 2 * (last_s - first_s) / crossings : std::numeric_limits<double>::infinity();
  const double left = (0.5 * end.velocity_m_s.squaredNorm() +
                       0.2 * kBobRadius_m * kBobRadius_m * end.angular_velocity_rad_s.squaredNorm() +
                       kGravity_m_s2 * (end.world_from_part.position_m.y() + kArm_m)) /
                      (kGravity_m_s2 * kArm_m * (1 - std::cos(amplitude_rad)));
  return stage.finish({relative("period", period_s, ball_pendulum_period_s(amplitude_rad), 1e-3),
                       absolute("energy_lost", 1 - left, 0.0, 0.01, "relative")});
}

Result<RigidOutcome> loaded_chain(const RigidSetup& setup) {
  constexpr int kLinks = 20;
  constexpr double kLink_m = 0.1, kThick_m = 0.02, kEnd_m = 0.1;
  auto made = RigidStage::make(setup);
  if (!made) return made.error();
  RigidStage& stage = *made;
  for (int i = 0; i <= kLinks; ++i) {
    RigidPart link;
    const double half_m = i < kLinks ? 0.5 * kLink_m : 0.5 * kEnd_m;
    link.size_m = i < kLinks ? Vector3d(kThick_m, kLink_m, kThick_m) : Vector3d::Constant(kEnd_m);
    link.mass_kg = i < kLinks ? 0.1 : 0.1 * setup.parameter;
    link.world_from_part.position_m = {0, -kLink_m * i - half_m, 0};
    stage.add(link);
    const std::optional<size_t> above = i > 0 ? std::optional<size_t>(i - 1) : std::nullopt;
    if (auto joined = stage.solver().join(i, above, {0, -kLink_m * i, 0}); !joined) return joined.error();
  }
  const double length_m = kLinks * kLink_m;
  const auto hangs_m = [&] { return -stage.motions().back().world_from_part.position_m.y() - 0.5 * kEnd_m; };
  const auto watch = [&] {
    if (hangs_m() > 2 * length_m) stage.mark(RunEnd::Fell);
  };
  stage.run(9.0, watch);
  double sum_m = 0.0;
  int frames = 0;
  stage.run(1.0, [&] {
    watch();
    sum_m += hangs_m();
    ++frames;
  });
  const double stretch = frames > 0 ? sum_m / frames / length_m - 1 : std::numeric_limits<double>::infinity();
  // Beyond 1:1000 the chain only has to hold: at most twice its length.
  const double bar = setup.parameter <= 100 ? 0.02 : setup.parameter <= 1000 ? 0.05 : 1.0;
  return stage.finish({absolute("stretch", stretch, 0.0, bar, "relative")});
}

}  // namespace livegs::study
