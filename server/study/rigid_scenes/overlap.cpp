// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <limits>

#include "study/harness/rigid_scenes.h"
#include "study/harness/rigid_stage.h"

namespace livegs::study {
namespace {

using Eigen::Vector3d;

RigidPart cube_at(const Vector3d& position_m) {
  RigidPart cube;
  cube.size_m.setOnes();
  cube.friction = 0.6;
  cube.world_from_part.position_m = position_m;
  return cube;
}

// The highest speed so far. Downward components are ignored, because gravity may cause them.
double fastest(const RigidStage& stage, double before) {
  for (const RigidMotion& motion : stage.motions()) {
    Vector3d v = motion.velocity_m_s;
    v.y() = std::max(0.0, v.y());
    before = std::max(before, v.norm());
  }
  return before;
}

}  // namespace

Result<RigidOutcome> overlap(const RigidSetup& setup) {
  auto made = RigidStage::make(setup);
  if (!made) return made.error();
  RigidStage& pyramid = *made;
  pyramid.solver().add_floor({}, 0.6);
  for (int row = 0; row < 4; ++row) {
    for (int i = 0; i < 4 - row; ++i) {
      pyramid.add(cube_at({0.5 * (i - 0.5 * (3 - row)), 0.5 + 0.5 * row, 0}));
    }
  }
  double pyramid_m_s = 0.0;
  pyramid.run(3.0, [&] { pyramid_m_s = fastest(pyramid, pyramid_m_s); });

  auto column = RigidStage::make(setup, {.gravity_m_s2 = Vector3d::Zero()});
  if (!column) return column.error();
  for (int i = 0; i < 10; ++i) column->add(cube_at({0, 0.5 * i, 0}));
  double column_m_s = 0.0;
  column->run(3.0, [&] { column_m_s = fastest(*column, column_m_s); });
  pyramid.include(*column);

  auto pair = RigidStage::make(setup, {.gravity_m_s2 = Vector3d::Zero()});
  if (!pair) return pair.error();
  pair->add(cube_at(Vector3d::Zero()));
  pair->add(cube_at(Vector3d::Zero()));
  double coincident_m_s = 0.0;
  pair->run(3.0, [&] { coincident_m_s = fastest(*pair, coincident_m_s); });
  const double apart_m =
      (pair->motions()[0].world_from_part.position_m - pair->motions()[1].world_from_part.position_m).norm();
  if (!(apart_m > 0.9)) coincident_m_s = std::numeric_limits<double>::infinity();
  pyramid.include(*pair);
  return pyramid.finish({absolute("column_speed", column_m_s, 0.0, 3.0, "m/s"),
                         absolute("pyramid_speed", pyramid_m_s, 0.0, 3.0, "m/s"),
                         absolute("coincident_speed", coincident_m_s, 0.0, 3.0, "m/s")});
}

}  // namespace livegs::study
