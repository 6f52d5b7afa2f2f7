// SPDX-License-Identifier: GPL-3.0-or-later
// SimBenchmark's rolling test: friction with the floor is fully used, and the balls roll without slipping.
#include <algorithm>
#include <cmath>

#include "study/harness/rigid_scenes.h"
#include "study/harness/rigid_stage.h"

namespace livegs::study {

using Eigen::Vector3d;

Result<RigidOutcome> rolling_box(const RigidSetup& setup) {
  constexpr double kBox_kg = 10.0, kBall_kg = 1.0, kPush_n = 150.0;
  constexpr double kUnderBox = 0.4, kUnderBalls = 0.8;
  constexpr int kSide = 5, kBalls = kSide * kSide;
  constexpr double kThick_m = 0.2, kRadius_m = 0.05;
  // The lowest point of a ball accelerates 3.5 times as fast as the force alone would accelerate the centre:
  // (1 + 5/2) f / m.
  const double from_floor_n = kUnderBox * (kBox_kg + kBalls * kBall_kg) * kGravity_m_s2;
  const double from_ball_n = (kPush_n - from_floor_n) / kBox_kg / (3.5 / kBall_kg + kBalls / kBox_kg);
  const double expected_m_s = (kPush_n - from_floor_n - kBalls * from_ball_n) / kBox_kg * 1.0;

  auto total = RigidStage::make(setup);
  if (!total) return total.error();
  double shown = 1.0, least = 1e300, most = -1e300;
  for (const Vector3d& along : {Vector3d(1, 0, 0), Vector3d(0, 0, 1), Vector3d(M_SQRT1_2, 0, M_SQRT1_2)}) {
    auto stage = RigidStage::make(setup);
    if (!stage) return stage.error();
    // Geometric means with the box's 0.8: 0.4 below it, 0.8 on it.
    stage->solver().add_floor({}, kUnderBox * kUnderBox / kUnderBalls);
    RigidPart box;
    box.size_m = {2.0, kThick_m, 2.0};
    box.mass_kg = kBox_kg;
    box.friction = kUnderBalls;
    box.world_from_part.position_m = {0, 0.5 * kThick_m, 0};
    stage->add(box);
    for (int i = 0; i < kBalls; ++i) {
      RigidPart ball;
      ball.radius_m = kRadius_m;
      ball.mass_kg = kBall_kg;
      ball.friction = kUnderBalls;
      ball.world_from_part.position_m = {0.3 * (i % kSide - 2), kThick_m + kRadius_m, 0.3 * (i / kSide - 2)};
      stage->add(ball);
    }
    stage->run(0.5);  // until all contacts carry their load
    const double start_m_s = stage->motions()[0].velocity_m_s.dot(along);
    stage->solver().push(0, kPush_n * along);
    stage->run(1.0);
    const double speed = stage->motions()[0].velocity_m_s.dot(along) - start_m_s;
    least = std::min(least, speed);
    most = std::max(most, speed);
    if (!(std::abs(speed / expected_m_s - 1) <= std::abs(shown - 1))) shown = speed / expected_m_s;
    total->include(*stage);
  }
  RigidOutcome outcome =
      total->finish({relative("speed", shown, 1.0, 0.01),
                     absolute("isotropy", (most - least) / expected_m_s, 0.0, 0.005, "relative")});
  outcome.bodies = 1 + kBalls;
  return outcome;
}

}  // namespace livegs::study
