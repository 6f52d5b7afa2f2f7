// SPDX-License-Identifier: GPL-3.0-or-later
// The impulse of a force of limited duration is force times duration at any rate.
#include <gtest/gtest.h>

#include "physics/world.h"
#include "scenes/rigid_fixtures.h"
#include "scenes/soft_fixtures.h"

namespace livegs {
namespace {

using namespace rigid_fixtures;
using Eigen::Vector3d;

TEST(WorldForce, ImpulseIsForceTimesDuration) {
  const double impulse_n_s = 0.3, mass_kg = 1.0;
  for (const double rate : {30.0, 45.0, 72.0, 90.0, 120.0}) {
    for (const double ticks : {0.1, 0.37, 1.0, 1.5, 2.0, 2.9, 3.7}) {
      for (const int start : {0, 17}) {
        SCOPED_TRACE(::testing::Message()
                     << ticks << " ticks from tick " << start << " at " << rate << " Hz");
        World world = world_at(rate, 4, Vector3d::Zero());
        ASSERT_TRUE(world.add_rigid(box_body(1, Vector3d::Constant(0.1), mass_kg)));
        ElasticBodyDescription soft = soft_fixtures::soft_block(2, {0.1, 0.1, 0.1}, mass_kg, 5e4, 0.02);
        soft.world_from_object.position_m = {1, 0, 0};
        ASSERT_TRUE(world.add_elastic(soft));
        for (int i = 0; i < start; ++i) world.step();
        const double duration_s = ticks / rate;
        const Vector3d force(impulse_n_s / duration_s, 0, 0);
        world.set_force(1, 1, {Vector3d::Zero(), force}, duration_s);
        world.set_force(2, 2, {Vector3d::Zero(), force}, duration_s);
        for (int i = 0; i < 5; ++i) world.step();
        const double of_rigid = mass_kg * body_state(world, 1).velocity_m_s.x();
        EXPECT_NEAR(of_rigid / impulse_n_s, 1.0, 1e-6);
        EXPECT_NEAR((world.energy().linear_momentum.x() - of_rigid) / impulse_n_s, 1.0, 1e-6);
      }
    }
  }
}

}  // namespace
}  // namespace livegs
