// SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/Geometry>
#include <cmath>

#include "core/math/rotation_between.h"
#include "study/harness/rigid_scenes.h"
#include "study/harness/rigid_stage.h"

namespace livegs::study {
namespace {

using Eigen::Vector3d;

constexpr double kSpeed_m_s = 3.0;
constexpr int kDrops = 100;

struct Drop {
  RigidPart box;
  double lowest_m = 0.0;  // of the lowest point, below the centre
};

// The falling box, and the impulse that stops it at the reference speed.
Drop flat_drop() {
  Drop drop;
  drop.box.size_m = {0.08, 0.1, 0.08};
  drop.box.mass_kg = 0.25;
  drop.box.break_impulse_n_s = drop.box.mass_kg * kSpeed_m_s;
  drop.lowest_m = 0.05;
  return drop;
}

// Nearly balanced on the corner, so that no other corner lands within the frame in which impacts are summed.
Drop corner_drop() {
  constexpr double kOffBalance_rad = 0.1;
  Drop drop = flat_drop();
  RigidPart& box = drop.box;
  box.friction = 0.0;
  const Vector3d corner = 0.5 * box.size_m;
  const Eigen::Quaterniond turn =
      Eigen::AngleAxisd(kOffBalance_rad, Vector3d::UnitX()) * rotation_between(corner, -Vector3d::UnitY());
  box.world_from_part.orientation = turn;
  const Vector3d s = box.size_m.cwiseProduct(box.size_m);
  const Vector3d moments = box.mass_kg / 12.0 * Vector3d(s.y() + s.z(), s.x() + s.z(), s.x() + s.y());
  const Vector3d arm = turn * corner;
  const Vector3d lever = turn.conjugate() * arm.cross(Vector3d::UnitY());
  box.break_impulse_n_s = kSpeed_m_s / (1.0 / box.mass_kg + lever.dot(lever.cwiseQuotient(moments)));
  drop.lowest_m = -arm.y();
  return drop;
}

}  // namespace

Result<RigidOutcome> break_height(const RigidSetup& setup) {
  auto total = RigidStage::make(setup);
  if (!total) return total.error();
  const Drop drop = setup.parameter > 0.0 ? corner_drop() : flat_drop();
  const double height_m = kSpeed_m_s * kSpeed_m_s / (2 * kGravity_m_s2);
  double shown = 1.0;
  for (int i = 0; i < kDrops; ++i) {
    const double share = 0.5 + (i + 0.5) / kDrops;
    auto stage = RigidStage::make(setup);
    if (!stage) return stage.error();
    RigidPart box = drop.box;
    box.world_from_part.position_m.y() = share * height_m + drop.lowest_m;
    stage->solver().add_floor({}, box.friction);
    stage->add(box);
    if (auto broken = stage->solver().broken(0); !broken) return broken.error();
    bool broke = false;
    // Until the landing and a few more frames.
    const double fall_s = std::sqrt(2 * share * height_m / kGravity_m_s2);
    stage->run(fall_s + 0.05, [&] { broke = broke || *stage->solver().broken(0); });
    if (broke != (share > 1.0) && std::abs(share - 1.0) > std::abs(shown - 1.0)) shown = share;
    total->include(*stage);
  }
  RigidOutcome outcome = total->finish({relative("height", shown, 1.0, 0.02)});
  outcome.bodies = 1;
  return outcome;
}

}  // namespace livegs::study
