// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <limits>

#include "study/harness/rigid_scenes.h"
#include "study/harness/rigid_stage.h"

namespace livegs::study {
namespace {

// A stack of touching cubes of 1 m.
Result<RigidStage> make_pile(const RigidSetup& setup, const std::vector<double>& masses_kg, bool sleep) {
  auto stage = RigidStage::make(setup, {.sleep = sleep});
  if (!stage) return stage.error();
  stage->solver().add_floor({}, 0.6);
  for (size_t i = 0; i < masses_kg.size(); ++i) {
    RigidPart cube;
    cube.size_m.setOnes();
    cube.mass_kg = masses_kg[i];
    cube.friction = 0.6;
    cube.world_from_part.position_m = {0, 0.5 + static_cast<double>(i), 0};
    stage->add(cube);
  }
  return stage;
}

}  // namespace

Result<RigidOutcome> box_stack(const RigidSetup& setup) {
  constexpr size_t kCubes = 20;
  const std::vector<double> masses_kg(kCubes, 1.0);
  auto made = make_pile(setup, masses_kg, false);
  if (!made) return made.error();
  RigidStage& stage = *made;
  const Eigen::Vector3d start = stage.motions().back().world_from_part.position_m;
  // The stack has collapsed when it is half a cube lower.
  const auto watch = [&] {
    if (stage.motions().back().world_from_part.position_m.y() < start.y() - 0.5) stage.mark(RunEnd::Fell);
  };
  stage.run(30.0, watch);
  const Eigen::Vector3d moved = stage.motions().back().world_from_part.position_m - start;
  const double lean_m = std::hypot(moved.x(), moved.z());

  auto sleepy = make_pile(setup, masses_kg, true);
  if (!sleepy) return sleepy.error();
  double asleep_s = std::numeric_limits<double>::infinity();
  sleepy->run(stage.ok() ? 10.0 : 0.0, [&] {
    const auto& motions = sleepy->motions();
    if (!std::isfinite(asleep_s) &&
        std::all_of(motions.begin(), motions.end(), [](const auto& m) { return m.asleep; })) {
      asleep_s = sleepy->time_s();
    }
  });
  return stage.finish({absolute("sag", std::abs(moved.y()) / kCubes, 0.0, 0.01, "relative"),
                       absolute("lean", lean_m, 0.0, 0.01, "m"),
                       absolute("asleep_after", asleep_s, 0.0, 5.0, "s")});
}

Result<RigidOutcome> heavy_on_light(const RigidSetup& setup) {
  auto made = make_pile(setup, {1.0, setup.parameter}, false);
  if (!made) return made.error();
  RigidStage& stage = *made;
  double sag = 0.0;
  stage.run(10.0, [&] {
    sag = 1.5 - stage.motions()[1].world_from_part.position_m.y();
    if (sag > 0.5) stage.mark(RunEnd::Fell);
  });
  const double bar = setup.parameter <= 10 ? 0.01 : setup.parameter <= 100 ? 0.05 : 0.10;
  return stage.finish({absolute("sag", std::abs(sag), 0.0, bar, "relative")});
}

}  // namespace livegs::study
