// SPDX-License-Identifier: Apache-2.0
// Two-way contact of elastic bodies with rigid bodies and with each other.
#include "baseline/elastic_solvers.h"
#include "known_gaps.h"
#include "server/physics/soft/soft_depth.h"

namespace livegs {
namespace {

using namespace soft_fixtures;

TEST(SoftContact, SphereAndCubeConserveMomentum) {
  for (const double rate : kRates_hz) {
    World world = world_with(make_elastic_body, rate, Vector3d::Zero());
    ElasticBodyDescription cube = soft_block(1, Vector3d::Constant(0.06), 0.216, 2e4, 0.01);
    ASSERT_TRUE(world.add_elastic(cube));
    BallDescription sphere = ball(2, {-0.2, 0.02, 0.01}, 0.05, 1.0);
    sphere.velocity_m_s = {2, 0, 0};
    ASSERT_TRUE(world.add_ball(sphere));
    const Drift drift = largest_drift(world, static_cast<int>(rate));
    EXPECT_GT(world.elastic_body(1)->velocity_m_s().x(), 0.5) << "no collision";
    EXPECT_LT(drift.linear, 1e-4);
    EXPECT_LT(drift.angular, 1e-3);
  }
}

TEST(SoftContact, BoxAndCubeConserveMomentum) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    World world = world_with(make_elastic_body, rate, Vector3d::Zero());
    ASSERT_TRUE(world.add_elastic(soft_block(1, Vector3d::Constant(0.06), 0.216, 2e4, 0.01)));
    RigidBodyDescription box = box_body(2, {0.08, 0.05, 0.06}, 1.0);
    box.world_from_object.position_m = {-0.2, 0.03, 0.01};
    box.world_from_object.orientation = rotation_about(3);
    box.velocity_m_s = {2, 0.1, 0};
    box.angular_velocity_rad_s = {3, -5, 4};
    ASSERT_TRUE(world.add_rigid(box));
    const Drift drift = largest_drift(world, rate);
    EXPECT_GT(world.elastic_body(1)->velocity_m_s().x(), 0.5);
    EXPECT_LT(drift.linear, 1e-4);
    EXPECT_LT(drift.angular, 1e-3);
  }
}

// A body that takes the place and the id of another touches with its own surface: half the extra height of
// the box overlaps the block at first and is pushed out.
TEST(SoftContact, BodyWithAReusedIdHasItsOwnContacts) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    World world = world_with(make_elastic_body, rate);
    world.add_collider(floor_plane(0.6));
    ElasticBodyDescription block = soft_block(1, {0.3, 0.1, 0.3}, 9.0, 1e5, 0.025, 0.3);
    block.world_from_object.position_m = {0, 0.05, 0};
    ASSERT_TRUE(world.add_elastic(block));
    RigidBodyDescription box = box_body(2, {0.1, 0.04, 0.1}, 0.1);
    box.world_from_object.position_m = {0, 0.121, 0};
    ASSERT_TRUE(world.add_rigid(box));
    run_seconds(world, 0.3);
    const double before_m = body_state(world, 2).world_from_body.position_m.y();
    RigidBodyDescription higher = box_body(2, {0.1, 0.05, 0.1}, 0.1);
    higher.world_from_object = body_state(world, 2).world_from_body;
    world.remove(2);
    ASSERT_TRUE(world.add_rigid(higher));
    run_seconds(world, 0.5);
    EXPECT_NEAR(body_state(world, 2).world_from_body.position_m.y() - before_m, 0.005, 0.001);
  }
}

TEST(SoftContact, TwoCubesConserveMomentum) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    World world = world_with(make_elastic_body, rate, Vector3d::Zero());
    ElasticBodyDescription one = soft_block(1, Vector3d::Constant(0.1), 0.5, 3e4, 0.0125);
    one.world_from_object.position_m = {-0.15, 0.02, 0};
    one.velocity_m_s = {2, 0, 0};
    ElasticBodyDescription two = soft_block(2, Vector3d::Constant(0.1), 0.3, 3e4, 0.0125);
    two.world_from_object.orientation = rotation_about(2);
    ASSERT_TRUE(world.add_elastic(one));
    ASSERT_TRUE(world.add_elastic(two));
    const BodyEnergy before = world.energy();
    const Drift drift = largest_drift(world, rate);
    EXPECT_GT(world.elastic_body(2)->velocity_m_s().x(), 0.5);
    EXPECT_LT(world.energy().kinetic_j, before.kinetic_j);
    EXPECT_LT(drift.linear, 1e-4);
    EXPECT_LT(drift.angular, 1e-3);
  }
}

TEST(SoftContact, BodiesCollideFarFromTheOrigin) {
  for (const ElasticBodyFactory solver : {make_elastic_body, make_livegs_v1_body}) {
    World world = world_with(solver, 60.0, Vector3d::Zero());
    ElasticBodyDescription cube = soft_block(1, Vector3d::Constant(0.1), 0.5, 3e4, 0.025);
    cube.world_from_object.position_m = {5.0, 3.0, -4.0};
    cube.velocity_m_s = {2, 0, 0};
    ASSERT_TRUE(world.add_elastic(cube));
    RigidBodyDescription box = box_body(2, Vector3d::Constant(0.1), 0.5);
    box.world_from_object.position_m = {5.15, 3.0, -4.0};
    ASSERT_TRUE(world.add_rigid(box));
    run_seconds(world, 0.2);
    EXPECT_GT(body_state(world, 2).velocity_m_s.x(), 0.5);
  }
}

TEST(SoftContact, HeavyBoxRestsOnAPillowAndBothSleep) {
  for (const double rate : kRates_hz) {
    World world = world_with(make_elastic_body, rate);
    world.add_collider(floor_plane(0.6));
    ElasticBodyDescription pillow = soft_block(1, {0.4, 0.1, 0.3}, 0.2, 2e4, 0.025);
    pillow.world_from_object.position_m = {0, 0.05, 0};
    ASSERT_TRUE(world.add_elastic(pillow));
    RigidBodyDescription box = box_body(2, {0.2, 0.15, 0.15}, 5.0);
    box.world_from_object.position_m = {0.02, 0.18, 0};
    ASSERT_TRUE(world.add_rigid(box));
    run_seconds(world, 8.0);
    // A load of 49 N on 0.03 m² of a pillow of 0.1 m and 2e4 Pa presses it by at most 8 mm; the pillow around
    // the box helps.
    const Vector3d rests = body_state(world, 2).world_from_body.position_m;
    EXPECT_GT(rests.y(), 0.175 - 0.009) << rate;
    EXPECT_LT(rests.y(), 0.175 - 0.001) << rate;
    run_seconds(world, 2.0);
    EXPECT_LT((body_state(world, 2).world_from_body.position_m - rests).norm(), 1e-4) << rate;
    EXPECT_LT(Vector3d(rests.x() - 0.02, 0, rests.z()).norm(), 0.006)
        << rate << ": sideways distance while bouncing";
    EXPECT_TRUE(body_state(world, 2).asleep) << rate;
    EXPECT_TRUE(world.elastic_body(1)->asleep()) << rate;
  }
}

// Pillows sampled as in a scene, compressed to two thirds. Oscillations of the Gauss-Seidel pass under the
// load must not move the box sideways or keep it awake.
// A box of 10 kg can tip over: its moment of 7.4 N m/rad exceeds the 5.6 N m/rad of a pillow of separate
// springs, by stiffness E over thickness t, E w d³ / 12 t, with the sides w and d of the box.
TEST(SoftContact, HeavyBoxOnVerySoftPillowDoesNotWalk) {
  struct Case {
    double modulus_pa, mass_kg;
  };
  for (const double rate : kRates_hz) {
    for (const Case& c :
         gate_or_full<Case>({{5e3, 5.0}, {1e4, 8.0}}, {{5e3, 5.0}, {7e3, 5.0}, {1e4, 5.0}, {1e4, 8.0}})) {
      SCOPED_TRACE(::testing::Message() << c.modulus_pa << " Pa, " << c.mass_kg << " kg, " << rate << " Hz");
      World world = world_with(make_elastic_body, rate);
      world.add_collider(floor_plane(0.6));
      ElasticBodyDescription pillow = soft_block(1, {0.4, 0.1, 0.3}, 0.2, c.modulus_pa, 0.025, 0.2);
      pillow.particles = sample_particles(box_mesh({0.4, 0.1, 0.3}), kDefaultSamplingDensity);
      pillow.world_from_object.position_m = {0, 0.051, 0};
      ASSERT_TRUE(world.add_elastic(pillow));
      RigidBodyDescription box = box_body(2, {0.2, 0.15, 0.15}, c.mass_kg);
      box.material.friction = 0.6;
      box.world_from_object.position_m = {0.02, 0.18, 0};
      ASSERT_TRUE(world.add_rigid(box));
      run_seconds(world, 5.0);
      const Vector3d then = body_state(world, 2).world_from_body.position_m;
      EXPECT_TRUE(body_state(world, 2).asleep && world.elastic_body(1)->asleep());
      run_seconds(world, 5.0);
      EXPECT_LT((body_state(world, 2).world_from_body.position_m - then).norm(), 1e-4);
    }
  }
}

}  // namespace
}  // namespace livegs
