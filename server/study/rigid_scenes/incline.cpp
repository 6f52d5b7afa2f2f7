// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "study/harness/rigid_scenes.h"
#include "study/harness/rigid_stage.h"

namespace livegs::study {
namespace {

using Eigen::Vector3d;

constexpr double kRadPerDegree = M_PI / 180;
constexpr double kSlid_m = 1e-3, kWatched_s = 2.0;  // detects 0.003 degrees above the threshold

// A slab at rest on a plane that descends towards +x.
struct Slope {
  RigidStage stage;
  Vector3d down;

  double travelled_m() const { return stage.motions()[0].world_from_part.position_m.dot(down); }
  double speed_m_s() const { return stage.motions()[0].velocity_m_s.dot(down); }
};

Result<Slope> make_slope(const RigidSetup& setup, double angle_rad, double friction) {
  auto stage = RigidStage::make(setup);
  if (!stage) return stage.error();
  Pose plane;
  plane.orientation = Eigen::AngleAxisd(-angle_rad, Vector3d::UnitZ());
  RigidPart slab;
  slab.size_m = {0.2, 0.05, 0.2};
  slab.friction = friction;
  slab.world_from_part.orientation = plane.orientation;
  slab.world_from_part.position_m = plane * Vector3d(0, 0.025, 0);
  stage->solver().add_floor(plane, friction);
  stage->add(slab);
  return Slope{std::move(*stage), plane.orientation * Vector3d::UnitX()};
}

}  // namespace

Result<RigidOutcome> incline(const RigidSetup& setup) {
  auto total = RigidStage::make(setup);
  if (!total) return total.error();
  double threshold_deg = 0.0, creep_m = 0.0, acceleration_error = 0.0, shown = 1.0;
  for (const double friction : {0.1, 0.3, 0.5, 0.7, 1.0}) {
    const double expected_rad = std::atan(friction);
    double held_rad = std::max(0.0, expected_rad - 4 * kRadPerDegree),
           slid_rad = expected_rad + 4 * kRadPerDegree;
    while (slid_rad - held_rad > 0.003 * kRadPerDegree) {
      const double angle_rad = 0.5 * (held_rad + slid_rad);
      auto slope = make_slope(setup, angle_rad, friction);
      if (!slope) return slope.error();
      slope->stage.run(kWatched_s);
      total->include(slope->stage);
      (slope->travelled_m() > kSlid_m ? slid_rad : held_rad) = angle_rad;
    }
    threshold_deg =
        std::max(threshold_deg, std::abs(0.5 * (held_rad + slid_rad) - expected_rad) / kRadPerDegree);

    auto held = make_slope(setup, expected_rad - kRadPerDegree, friction);
    if (!held) return held.error();
    held->stage.run(0.5);
    const double settled_m = held->travelled_m();
    held->stage.run(10.0);
    creep_m = std::max(creep_m, std::abs(held->travelled_m() - settled_m));
    total->include(held->stage);

    const double steep_rad = expected_rad + 10 * kRadPerDegree;
    auto slides = make_slope(setup, steep_rad, friction);
    if (!slides) return slides.error();
    slides->stage.run(0.5);
    const double start_m_s = slides->speed_m_s();
    slides->stage.run(0.5);
    const double ratio = (slides->speed_m_s() - start_m_s) /
                         (0.5 * kGravity_m_s2 * (std::sin(steep_rad) - friction * std::cos(steep_rad)));
    if (!(std::abs(ratio - 1) <= acceleration_error)) {
      acceleration_error = std::abs(ratio - 1);
      shown = ratio;
    }
    total->include(slides->stage);
  }
  RigidOutcome outcome =
      total->finish({absolute("threshold", threshold_deg, 0.0, 0.5, "degrees"),
                     absolute("creep", creep_m, 0.0, 1e-4, "m"), relative("acceleration", shown, 1.0, 0.01)});
  outcome.bodies = 1;
  return outcome;
}

}  // namespace livegs::study
