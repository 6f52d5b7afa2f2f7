// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "study/harness/rigid_scenes.h"
#include "study/harness/rigid_stage.h"

namespace livegs::study {

Result<RigidOutcome> stopping(const RigidSetup& setup) {
  auto total = RigidStage::make(setup);
  if (!total) return total.error();
  double shown = 1.0, drift_m_s = 0.0;
  for (const double friction : {0.2, 0.4, 0.7}) {
    for (const double turn_rad : {0.0, M_PI_4}) {
      auto stage = RigidStage::make(setup);
      if (!stage) return stage.error();
      RigidPart slab;
      slab.size_m = {0.2, 0.05, 0.2};
      slab.friction = friction;
      slab.world_from_part.position_m = {0, 0.025, 0};
      slab.velocity_m_s = 2.0 * Eigen::Vector3d(std::cos(turn_rad), 0, std::sin(turn_rad));
      stage->solver().add_floor({}, friction);
      stage->add(slab);
      const auto travelled_m = [&] {
        Eigen::Vector3d way = stage->motions()[0].world_from_part.position_m;
        way.y() = 0.0;
        return way.norm();
      };
      stage->run(1.5);  // 1.02 s at the lowest friction
      const double stopped_m = travelled_m();
      stage->run(1.0);
      drift_m_s = std::max(drift_m_s, std::abs(travelled_m() - stopped_m));
      const double ratio = stopped_m / (2.0 * 2.0 / (2 * friction * kGravity_m_s2));
      if (!(std::abs(ratio - 1) <= std::abs(shown - 1))) shown = ratio;
      total->include(*stage);
    }
  }
  RigidOutcome outcome = total->finish(
      {relative("distance", shown, 1.0, 0.005), absolute("drift", drift_m_s, 0.0, 1e-3, "m/s")});
  outcome.bodies = 1;
  return outcome;
}

}  // namespace livegs::study
