// SPDX-License-Identifier: Apache-2.0
// Contact of elastic bodies with the ground and with balls.
#include "scenes/elastic_bodies.h"

namespace livegs::test {
namespace {

// Lowest centre of the voxel faces on the underside of the 0.1 m cube.
double lowest_m(const ElasticBody& body) {
  double low = 1e300;
  for (int i = 1; i < 15; i += 2) {
    for (int j = 1; j < 15; j += 2) {
      low = std::min(low, body.world_point({-0.05 + i * 0.00625, -0.05, -0.05 + j * 0.00625}).y());
    }
  }
  return low;
}

TEST(ElasticContact, DroppedCubeNeverGainsEnergyOrSinks) {
  // A 0.1 m cube falls 0.1 m without damping, Co <= 0.67. The total energy must not exceed its start value.
  for (const double rate_hz : kRates_hz) {
    for (const int substeps : {4, 16}) {
      SCOPED_TRACE(testing::Message() << rate_hz << " Hz, " << substeps << " substeps");
      Stage stage;
      stage.rate_hz = rate_hz;
      stage.substeps = substeps;
      stage.gravity_m_s2 = kGravity;
      stage.add_floor(0.5);
      ElasticBodyDescription cube = describe(particle_grid(Vector3d::Constant(0.1), 0.0125), 1e4, 0.3, 0.025);
      cube.world_from_object.position_m = {0, 0.15, 0};
      stage.make(cube);
      ASSERT_LE(stage.body->accuracy().courant, 0.67);
      const double start = stage.total_energy_j();
      double peak = 0.0, low = 1.0, rebound = 0.0;
      for (int frame = 0; frame < 2 * rate_hz; ++frame) {
        stage.frame();
        peak = std::max(peak, stage.total_energy_j());
        low = std::min(low, lowest_m(*stage.body));
        if (frame > 0.25 * rate_hz) rebound = std::max(rebound, stage.body->centre_pose().position_m.y());
      }
      // The first step is of first order and is g h²/2 too long: less than 1e-3 of the fall.
      EXPECT_LT(peak / start, 1.001);
      // Contact is solved last and only pushes outwards. Only friction can move a point that has already
      // separated.
      EXPECT_GT(low, -1e-6);
      EXPECT_NEAR(rebound, 0.090, 0.018);  // the result at 64 substeps; bar 20 %
    }
  }
}

TEST(ElasticContact, SoftBlockSleepsAtItsStaticHeight) {
  // At nu = 0 a column under its weight moves down by rho g (H y - y²/2) / E at height y. Its centre of mass
  // moves by the mean, rho g H² / 3E.
  const double height = 0.2, stiffness = 5e4;
  Stage stage;
  stage.gravity_m_s2 = kGravity;
  stage.add_floor(0.0);
  ElasticBodyDescription block =
      describe(particle_grid(Vector3d::Constant(height), 0.025), stiffness, 0.0, 0.05);
  block.material.loss_factor = 0.5;
  block.world_from_object.position_m = {0, 0.15, 0};
  stage.make(block, make_elastic_body, true);
  stage.run(6.0);
  EXPECT_TRUE(stage.body->asleep());
  const double sag = 1000 * 9.81 * height * height / (3 * stiffness);
  // 5 % of the sag is for the modulus, the rest for the sleep threshold.
  EXPECT_NEAR((0.5 * height - stage.body->centre_pose().position_m.y()) / sag, 1.0, 0.1);

  const Vector3d asleep_at = stage.body->centre_pose().position_m;
  stage.run(1.0);
  EXPECT_EQ(stage.body->centre_pose().position_m, asleep_at);
  stage.forces.push_back({{0, 0.1, 0}, {0, 30, 0}});
  stage.frame();
  EXPECT_FALSE(stage.body->asleep());
}

TEST(ElasticContact, FrictionHoldsBelowItsLimitAndSlidesAbove) {
  // A slab that never sleeps on an incline of 20 degrees (tan = 0.364). Below the friction limit it does not
  // creep within 10 s. Above it a = g (sin - mu cos), within 5 % for the slab's own vibration.
  for (const double rate_hz : kRates_hz) {
    for (const double friction : {0.6, 0.2}) {
      SCOPED_TRACE(testing::Message() << rate_hz << " Hz, friction " << friction);
      Stage stage;
      stage.rate_hz = rate_hz;
      const double angle = 20.0 * M_PI / 180.0;
      stage.gravity_m_s2 = {9.81 * std::sin(angle), -9.81 * std::cos(angle), 0};
      stage.add_floor(friction);
      ElasticBodyDescription slab = describe(particle_grid({0.2, 0.05, 0.2}, 0.025), 2e5, 0.3);
      slab.material.friction = friction;
      slab.material.loss_factor = 1.0;
      slab.world_from_object.position_m = {0, 0.025, 0};
      stage.make(slab);
      stage.run(0.5);
      const Vector3d from_m = stage.body->centre_m(), speed_m_s = stage.body->velocity_m_s();
      stage.run(friction > 0.5 ? 10.0 : 1.0);
      if (friction > 0.5) {
        EXPECT_LT((stage.body->centre_m() - from_m).norm(), 1e-4);
      } else {
        const double expected = 9.81 * (std::sin(angle) - friction * std::cos(angle));
        EXPECT_NEAR((stage.body->velocity_m_s() - speed_m_s).x() / expected, 1.0, 0.05);
      }
    }
  }
}

TEST(ElasticContact, RegionsHaveTheirOwnFriction) {
  // A block of two halves slides at x > 0 first. The deceleration of a rigid one of length L and height h,
  // with the friction f of its front and b of its back: g m / (1 - (f - b) h / 2L), with the mean m. Loads
  // spread over the two halves instead of sitting at the ends, hence 10 %; with one friction for all it is 40
  // % off.
  for (const double rate_hz : kRates_hz) {
    for (const bool by_factor : {false, true}) {
      SCOPED_TRACE(testing::Message() << rate_hz << " Hz, by factor " << by_factor);
      Stage stage;
      stage.rate_hz = rate_hz;
      stage.gravity_m_s2 = kGravity;
      stage.add_floor(0.5);
      ElasticBodyDescription block = describe(particle_grid({0.4, 0.05, 0.2}, 0.025), 1e6, 0.3);
      block.material.friction = 0.5;
      block.material.loss_factor = 1.0;
      block.world_from_object.position_m = {0, 0.025, 0};
      block.velocity_m_s = {3, 0, 0};
      BodyRegion right;
      right.min_m = {0, -1, -1};
      right.max_m = {1, 1, 1};
      right.material = RegionMaterial();
      if (by_factor) {
        right.material->friction_factor = 0.1;
      } else {
        right.material->friction = 0.05;
      }
      block.regions.push_back(right);
      stage.make(block);
      stage.run(0.2);
      const double before_m_s = stage.body->velocity_m_s().x();
      stage.run(0.3);
      const double front = std::sqrt(0.5 * 0.05), back = 0.5;
      const double expected = 9.81 * 0.5 * (front + back) / (1.0 - 0.5 * (front - back) * 0.05 / 0.4);
      EXPECT_NEAR((before_m_s - stage.body->velocity_m_s().x()) / 0.3 / expected, 1.0, 0.1);
    }
  }
}

TEST(ElasticContact, BallImpulseEqualsBodyMomentum) {
  Stage stage;
  stage.make(describe(particle_grid(Vector3d::Constant(0.1), 0.0125), 2e4, 0.3));
  const RigidShape shape = ball_shape(0.03);
  RigidProxy ball;
  ball.body_id = 2;
  ball.shape = &shape;
  ball.start.position_m = {0.3, 0.01, 0};
  ball.velocity_m_s = {-3, 0, 0};
  ball.inverse_mass = 1 / 0.2;
  ball.inverse_inertia = Matrix3d::Identity() / (0.4 * 0.2 * 0.03 * 0.03);
  SurfaceFriction friction;
  friction.own = 0.4;
  ball.friction = &friction;
  Vector3d given = Vector3d::Zero();
  for (int i = 0; i < 240; ++i) {
    ball.impulse_n_s.setZero();
    stage.bodies = {&ball};
    stage.substep();
    ball.start = ball.at_end();
    given += ball.impulse_n_s;
  }
  const Vector3d momentum = stage.body->energy(kNoGravity).linear_momentum;
  // The momentum sum is exact; nodes are in single precision: 1e-7 of 0.6 kg m/s.
  EXPECT_NEAR((momentum + given).norm(), 0.0, 1e-7);
  EXPECT_GT(momentum.x(), -0.2 * 3 * 2.0);  // at most a perfect rebound
  EXPECT_LT(momentum.x(), -0.2 * 3 * 0.8);
  EXPECT_GT(ball.velocity_m_s.x(), -0.6);  // stopped or reflected: 0.2 kg hits 1 kg
  EXPECT_TRUE(all_finite(*stage.body));
}

TEST(ElasticContact, DeepOverlapWithFloorSeparatesSlowly) {
  // Half of the cube, or nine tenths of it, starts below the floor. Rigid boxes separate below 3 m/s. An
  // inner point is pushed out at most at the push speed, and the energy stored by compression adds to it.
  struct Case {
    double size_m, young_modulus_pa;
  };
  for (const auto& [size, stiffness] : {Case{0.1, 1e4}, Case{0.1, 1e6}, Case{10.0, 3e5}, Case{10.0, 1e6}}) {
    for (const double above : {0.5, 0.1}) {
      Stage stage;
      stage.substeps = 4;
      stage.gravity_m_s2 = kGravity;
      stage.add_floor(0.5);
      ElasticBodyDescription cube =
          describe(particle_grid(Vector3d::Constant(size), size / 8), stiffness, 0.3, size / 4);
      cube.world_from_object.position_m = {0, (above - 0.5) * size, 0};
      stage.make(cube);
      double fastest_m_s = 0.0;
      for (int frame = 0; frame < (size > 1.0 ? 1080 : 180); ++frame) {
        stage.frame();
        fastest_m_s = std::max(fastest_m_s, stage.body->velocity_m_s().y());
      }
      EXPECT_LT(fastest_m_s, 3.0) << size << ' ' << above << ' ' << stiffness;
      // Fully separated: the middle of a column sags by 3 rho g H / 8E, 0.123 of its height for the softest
      // cube.
      EXPECT_GT(stage.body->centre_pose().position_m.y(), 0.35 * size)
          << size << ' ' << above << ' ' << stiffness;
    }
  }
}

}  // namespace
}  // namespace livegs::test
