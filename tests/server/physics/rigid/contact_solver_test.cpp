// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <vector>

#include "physics/collision/collision_shape.h"
#include "physics/rigid/contact/contact_solver.h"
#include "scenes/rigid_fixtures.h"

namespace livegs {
namespace {

using namespace rigid_fixtures;
using Eigen::Vector3d;

// Heights of the peaks after each bounce.
std::vector<double> bounce_peaks(World& world, uint32_t id, double rest_height, double seconds) {
  std::vector<double> peaks;
  double highest = 0.0;
  bool rising = false;
  for (int i = 0; i < static_cast<int>(seconds * world.settings().rate_hz); ++i) {
    world.step();
    const BodyState state = body_state(world, id);
    const double speed = state.velocity_m_s.y();
    // Adds the remaining rise at this moment, so that the peak does not depend on tick boundaries.
    const double height =
        state.world_from_body.position_m.y() - rest_height + speed * speed / (2.0 * kGravity);
    if (speed > 0.05) {
      highest = height;
      rising = true;
    } else if (rising) {
      peaks.push_back(highest);
      rising = false;
    }
  }
  return peaks;
}

TEST(RigidContact, BallBouncesToTheSquareOfRestitution) {
  for (const double rate : kRates_hz) {
    for (const double e : {0.5, 0.8, 1.0}) {
      World world = world_at(rate, 4);
      world.add_collider(floor_plane(0.5, e));
      auto description = ball(1, {0, 1.05, 0});
      description.restitution = e;
      ASSERT_TRUE(world.add_ball(description));
      const std::vector<double> peaks = bounce_peaks(world, 1, 0.05, 6.0);
      ASSERT_GE(peaks.size(), 3u);
      double expected = 1.0;
      for (size_t i = 0; i < 3; ++i) {
        expected *= e * e;
        EXPECT_NEAR(peaks[i] / expected, 1.0, 0.01)
            << "e " << e << " bounce " << i << " rate " << rate;  // scene 4
      }
    }
  }
}

TEST(RigidContact, PerfectBouncesKeepTheirEnergy) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    World world = world_at(rate, 4);
    world.add_collider(floor_plane(0.5, 1.0));
    ASSERT_TRUE(world.add_ball(ball(1, {0, 1.05, 0})));
    const std::vector<double> peaks = bounce_peaks(world, 1, 0.05, 10.5);  // a bounce takes 0.903 s
    ASSERT_GE(peaks.size(), 10u);
    EXPECT_NEAR(peaks[9], 1.0, 0.005);  // scene 4
  }
}

TEST(RigidContact, WithoutRestitutionNothingBounces) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    World world = world_at(rate, 4);
    world.add_collider(floor_plane());
    auto box = box_body(1, {0.1, 0.1, 0.1}, 0.5);
    box.world_from_object.position_m = {0, 1.05, 0};
    ASSERT_TRUE(world.add_rigid(box));
    run_seconds(world, 0.5);  // 0.4515 s to fall 1 m
    double highest = 0.0;
    for (int i = 0; i < rate; ++i) {
      world.step();
      highest = std::max(highest, body_state(world, 1).world_from_body.position_m.y());
    }
    EXPECT_LT(highest, 0.05 + 1e-4);  // a thousandth of its size
  }
}

// Bodies that bounce on corners and edges, at e = 1 and 0.9 with little or no friction, gain no energy.
// Newton's restitution rule applied to each point alone would add energy.
TEST(RigidContact, SharpBodiesGainNothingOnBouncing) {
  for (const double rate : kRates_hz) {
    for (const double restitution : {1.0, 0.9}) {
      for (const double friction : {0.0, 0.05}) {
        for (int i = 0; i < 4; ++i) {
          std::ostringstream what;
          what << rate << " Hz, e " << restitution << ", mu " << friction << ", way " << i;
          SCOPED_TRACE(what.str());
          World world = world_at(rate, 4);
          world.add_collider(floor_plane(friction, restitution));
          auto thing =
              i == 3 ? body_of(1, cylinder_mesh(0.04, 0.2), 0.5) : box_body(1, {0.1, 0.12, 0.08}, 0.5);
          thing.material.restitution = restitution;
          thing.material.friction = friction;
          thing.world_from_object = {Vector3d(0, 0.5, 0), rotation_about(i + 1)};
          ASSERT_TRUE(world.add_rigid(thing));
          const auto total = [&] { return world.energy().kinetic_j + world.energy().gravity_j; };
          const double start_j = total();
          double most_j = start_j;
          for (int tick = 0; tick < 6 * rate; ++tick) {
            world.step();
            most_j = std::max(most_j, total());
          }
          EXPECT_LT(most_j, 1.001 * start_j);
          if (restitution == 1.0 && friction == 0.0) EXPECT_GT(total(), 0.5 * start_j);  // and it does bounce
        }
      }
    }
  }
}

TEST(RigidContact, BoxLandingFlatBouncesToTheSquareOfRestitution) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    World world = world_at(rate, 4);
    world.add_collider(floor_plane(0.5, 0.5));
    auto box = box_body(1, {0.1, 0.1, 0.1}, 0.5);
    box.world_from_object.position_m = {0, 0.55, 0};
    ASSERT_TRUE(world.add_rigid(box));
    const std::vector<double> peaks = bounce_peaks(world, 1, 0.05, 1.5);
    ASSERT_GE(peaks.size(), 1u);
    EXPECT_NEAR(peaks[0] / 0.125, 1.0, 0.01);  // e² h; four corners share the impact in four passes
  }
}

// Motion of a slab along the slope of an incline: position and speed after `seconds`, and position after the
// first tick.
struct Slide {
  double way_m, speed_m_s, settled_m;
};
Slide slab_on_incline(double angle_rad, double friction, double seconds, double rate = 60.0) {
  World world = world_at(rate, 4);
  world.add_collider(incline(angle_rad, friction));
  auto slab = box_body(1, {0.2, 0.05, 0.2}, 1.0);
  slab.material.friction = friction;
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(-angle_rad, Vector3d::UnitZ()));
  slab.world_from_object.orientation = turn;
  slab.world_from_object.position_m = turn * Vector3d(0, 0.025, 0);
  EXPECT_TRUE(world.add_rigid(slab));
  const Vector3d down = turn * Vector3d::UnitX();
  world.step();
  const double start = body_state(world, 1).world_from_body.position_m.dot(down);
  run_seconds(world, seconds);
  const BodyState state = body_state(world, 1);
  return {state.world_from_body.position_m.dot(down), state.velocity_m_s.dot(down), start};
}

TEST(RigidContact, InclineSlidesOnlyAboveTheFrictionAngle) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    for (const double friction : {0.1, 0.3, 0.5, 0.7, 1.0}) {
      const double threshold = std::atan(friction);
      const Slide held = slab_on_incline(threshold - radians(0.5), friction, 1.0, rate);
      const Slide slid = slab_on_incline(threshold + radians(0.5), friction, 1.0, rate);
      EXPECT_LT(std::abs(held.way_m), 1e-4) << friction;  // scene 2: 0.1 mm
      // Half a degree above the friction angle, g (sin - mu cos) / 2 gives at least 42 mm in 1 s. A tenth of
      // that shows sliding.
      EXPECT_GT(slid.way_m, 4e-3) << friction;
    }
  }
}

TEST(RigidContact, HeldSlabDoesNotCreep) {
  for (const double rate : kRates_hz) {
    // 20 degrees at mu 0.4, 1.8 degrees below the friction angle. Sleep is off, so only friction holds the
    // slab.
    WorldSettings settings;
    settings.rate_hz = rate;
    settings.sleep = false;
    World world(settings);
    world.add_collider(incline(radians(20), 0.4));
    auto slab = box_body(1, {0.2, 0.05, 0.2}, 1.0);
    slab.material.friction = 0.4;
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(-radians(20), Vector3d::UnitZ()));
    slab.world_from_object.orientation = turn;
    slab.world_from_object.position_m = turn * Vector3d(0, 0.025, 0);
    ASSERT_TRUE(world.add_rigid(slab));
    run_seconds(world, 10.0);
    EXPECT_LT(std::abs(body_state(world, 1).world_from_body.position_m.dot(turn * Vector3d::UnitX())), 1e-4);
  }
}

TEST(RigidContact, SlidingAcceleratesByGravityLessFriction) {
  const double angle = radians(30), friction = 0.3;
  const double expected = kGravity * (std::sin(angle) - friction * std::cos(angle));
  for (const double rate : kRates_hz) {
    const Slide slide = slab_on_incline(angle, friction, 1.0, rate);
    EXPECT_NEAR(slide.speed_m_s / (expected * (1.0 + 1.0 / rate)), 1.0, 0.01);  // scene 2
  }
}

TEST(RigidContact, SlidingStopsAfterItsDistance) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    for (const double friction : {0.2, 0.4, 0.7}) {
      for (const bool diagonal : {false, true}) {
        World world = world_at(rate, 4);
        world.add_collider(floor_plane(friction));
        auto slab = box_body(1, {0.2, 0.05, 0.2}, 1.0);
        slab.material.friction = friction;
        slab.world_from_object.position_m = {0, 0.025, 0};
        slab.velocity_m_s = diagonal ? Vector3d(std::sqrt(2.0), 0, std::sqrt(2.0)) : Vector3d(2, 0, 0);
        ASSERT_TRUE(world.add_rigid(slab));
        run_seconds(world, 2.0);
        const BodyState state = body_state(world, 1);
        Vector3d way = state.world_from_body.position_m;
        way.y() = 0.0;
        EXPECT_NEAR(way.norm() / (4.0 / (2.0 * friction * kGravity)), 1.0, 0.005)  // scene 3
            << friction << " diagonal " << diagonal;
        EXPECT_LT(state.velocity_m_s.norm(), 1e-3);
      }
    }
  }
}

TEST(RigidContact, BallRollsAtFiveSevenths) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    const double angle = radians(20);
    World world = world_at(rate, 4);
    world.add_collider(incline(angle, 0.5));
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(-angle, Vector3d::UnitZ()));
    ASSERT_TRUE(world.add_ball(ball(1, turn * Vector3d(0, 0.05, 0))));
    run_seconds(world, 1.0);
    const BodyState state = body_state(world, 1);
    EXPECT_NEAR(state.velocity_m_s.norm() / (5.0 / 7.0 * kGravity * std::sin(angle)), 1.0, 0.01);  // scene 12
    EXPECT_NEAR(state.angular_velocity_rad_s.norm() * 0.05 / state.velocity_m_s.norm(), 1.0, 0.005);
  }
}

TEST(RigidContact, SlippingBallEndsRollingAtFiveSevenths) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    World world = world_at(rate, 4);
    world.add_collider(floor_plane(0.2));
    auto description = ball(1, {0, 0.05, 0});
    description.friction = 0.2;
    description.velocity_m_s = {1, 0, 0};
    ASSERT_TRUE(world.add_ball(description));
    run_seconds(world, 1.0);  // pure rolling starts at 2 v0 / (7 mu g) = 0.15 s
    EXPECT_NEAR(body_state(world, 1).velocity_m_s.x(), 5.0 / 7.0, 0.01 * 5.0 / 7.0);  // scene 12
  }
}

TEST(RigidContact, TwistFrictionStopsSpinOnTheFloor) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    World world = world_at(rate, 4);
    world.add_collider(floor_plane(0.5));
    auto slab = box_body(1, {0.2, 0.05, 0.2}, 1.0);
    slab.world_from_object.position_m = {0, 0.025, 0};
    slab.angular_velocity_rad_s = {0, 10, 0};
    ASSERT_TRUE(world.add_rigid(slab));
    run_seconds(world, 0.1);
    // Four corners at r = 0.1414 m carry the weight: alpha = mu g r / (a²/6) = 104 rad/s².
    const double slowing = 0.5 * kGravity * 0.1 * std::sqrt(2.0) / (0.04 / 6.0);
    const double expected = std::max(0.0, 10.0 - slowing * 0.1);
    EXPECT_NEAR(body_state(world, 1).angular_velocity_rad_s.y(), expected, 0.2);  // within 2 % of the start
  }
}

TEST(RigidContact, RestingBoxSleepsAndHardlySinks) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    for (const double size : {0.02, 0.1, 0.5}) {
      World world = world_at(rate, 4);
      world.add_collider(floor_plane());
      auto box = box_body(1, Vector3d::Constant(size), 1000.0 * size * size * size);
      box.world_from_object.position_m = {0, 0.5 * size + 0.01, 0};
      ASSERT_TRUE(world.add_rigid(box));
      run_seconds(world, 2.0);
      const BodyState state = body_state(world, 1);
      EXPECT_TRUE(state.asleep) << size;
      // The contact spring sags by g / (2 pi 60 Hz)² = 0.07 mm at any size.
      EXPECT_NEAR(state.world_from_body.position_m.y(), 0.5 * size, 1.2e-4) << size;
      EXPECT_LT(Eigen::Quaterniond::Identity().angularDistance(state.world_from_body.orientation), 1e-3)
          << size;
    }
  }
}

TEST(RigidContact, RestingBoxDoesNotJitter) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    WorldSettings settings;
    settings.rate_hz = rate;
    settings.sleep = false;
    World world(settings);
    world.add_collider(floor_plane());
    auto box = box_body(1, {0.1, 0.06, 0.14}, 0.5);
    box.world_from_object.position_m = {0, 0.031, 0};
    ASSERT_TRUE(world.add_rigid(box));
    run_seconds(world, 3.0);
    double fastest = 0.0, turning = 0.0;
    for (int i = 0; i < 2 * rate; ++i) {
      world.step();
      fastest = std::max(fastest, body_state(world, 1).velocity_m_s.norm());
      turning = std::max(turning, body_state(world, 1).angular_velocity_rad_s.norm());
    }
    // The relax pass removes the push velocity: a fixed point, up to the spring's slow settling.
    EXPECT_LT(fastest, 1e-5);
    EXPECT_LT(turning, 1e-4);
  }
}

TEST(RigidContact, TallBoxFallsOnlyBeyondItsTippingAngle) {
  // Half width over half height 0.25: tips at 14.04 degrees.
  for (const double lean : {10.0, 18.0}) {
    World world = world_at(60, 4);
    world.add_collider(floor_plane(1.0));
    auto box = box_body(1, {0.05, 0.2, 0.05}, 0.5);
    box.material.friction = 1.0;
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(-radians(lean), Vector3d::UnitZ()));
    box.world_from_object.orientation = turn;
    box.world_from_object.position_m = -(turn * Vector3d(0.025, -0.1, 0));  // rests on its lower right edge
    ASSERT_TRUE(world.add_rigid(box));
    run_seconds(world, 3.0);
    const double height = body_state(world, 1).world_from_body.position_m.y();
    EXPECT_NEAR(height, lean < 14.0 ? 0.1 : 0.025, 1e-3) << lean;
  }
}

TEST(RigidContact, BoxLyingOverATableEdgeStays) {
  World world = world_at(60, 4);
  Collider table{BoxShape{{0.4, 0.2, 0.4}}, Pose{}, 0.6, 0.0};
  world.add_collider(table);
  world.add_collider(floor_plane());
  world.add_collider(Collider{PlaneShape{}, Pose{{0, -1, 0}, Eigen::Quaterniond::Identity()}, 0.5, 0.0});
  auto box = box_body(1, {0.3, 0.04, 0.08}, 0.5);
  // 0.05 m of the half length of 0.15 m overhangs the edge; the centre of mass is above the table.
  box.world_from_object.position_m = {0.1, 0.1 + 0.02, 0};
  ASSERT_TRUE(world.add_rigid(box));
  run_seconds(world, 2.0);
  const BodyState state = body_state(world, 1);
  EXPECT_NEAR(state.world_from_body.position_m.y(), 0.12, 5e-4);
  EXPECT_NEAR(state.world_from_body.position_m.x(), 0.1, 5e-4);
  EXPECT_TRUE(state.asleep);
}

TEST(RigidContact, RailHoldsBeamAcrossIt) {
  // Only the rail's edges touch the beam's face; all corners of the beam are far away.
  World world = world_at(60, 4);
  Collider rail{BoxShape{{0.01, 0.1, 0.6}}, Pose{{0, 0.05, 0}, Eigen::Quaterniond::Identity()}, 0.6, 0.0};
  world.add_collider(rail);
  auto beam = box_body(1, {0.4, 0.03, 0.05}, 0.4);
  beam.world_from_object.position_m = {0, 0.1 + 0.015 + 0.002, 0};
  ASSERT_TRUE(world.add_rigid(beam));
  run_seconds(world, 1.0);
  // balanced on a rail 1 cm wide
  EXPECT_NEAR(body_state(world, 1).world_from_body.position_m.y(), 0.115, 1e-3);
}

TEST(RigidContact, SphereHoldsFlatFace) {
  World world = world_at(60, 4);
  world.add_collider(Collider{SphereShape{0.1}, Pose{}, 0.8, 0.0});
  auto slab = box_body(1, {0.2, 0.04, 0.2}, 0.4);
  slab.material.friction = 0.8;
  slab.world_from_object.position_m = {0, 0.125, 0};
  ASSERT_TRUE(world.add_rigid(slab));
  run_seconds(world, 0.5);
  // Stable: half thickness 0.02 < radius 0.1.
  EXPECT_NEAR(body_state(world, 1).world_from_body.position_m.y(), 0.12, 1e-3);
}

TEST(RigidContact, OverlapsSeparateSlowly) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    World world = world_at(rate, 4);
    world.add_collider(floor_plane());
    auto box = box_body(1, {0.1, 0.1, 0.1}, 0.5);
    box.world_from_object.position_m = {0, 0, 0};  // half sunk
    ASSERT_TRUE(world.add_rigid(box));
    double fastest = 0.0;
    for (int i = 0; i < 2 * rate; ++i) {
      world.step();
      fastest = std::max(fastest, body_state(world, 1).velocity_m_s.norm());
    }
    EXPECT_LT(fastest, 1.0);  // a third of scene 19's bar, at a tenth of its size
    EXPECT_NEAR(body_state(world, 1).world_from_body.position_m.y(), 0.05, 2e-4);
  }
}

TEST(RigidContact, TumblingBoxNeverGainsEnergy) {
  for (int seed = 0; seed < 8; ++seed) {
    World world = world_at(90, 4);
    world.add_collider(floor_plane(0.4, 0.3));
    auto box = box_body(1, {0.12, 0.05, 0.2}, 0.5);
    box.world_from_object.position_m = {0, 0.4, 0};
    box.angular_velocity_rad_s = {7.0 + 3.0 * seed, -11.0 + 5.0 * seed, 17.0 - 4.0 * seed};
    box.velocity_m_s = {1.0, 0, -0.5};
    ASSERT_TRUE(world.add_rigid(box));
    double before = world.energy().kinetic_j + world.energy().gravity_j;
    for (int i = 0; i < 90 * 3; ++i) {
      world.step();
      const double energy = world.energy().kinetic_j + world.energy().gravity_j;
      // The spring that separates an overlap lifts the box by at most the overlap of one substep: m g 1 mm =
      // 5 mJ.
      ASSERT_LT(energy, before + 5e-3) << "seed " << seed << " tick " << i;
      before = std::min(before, energy);
    }
  }
}

constexpr double kFastRadius_m = 0.025;

// Throws a ball of 50 mm at a plate of 5 mm, at 1 to 100 m/s and at an angle. The ball must hit the plate and
// never be inside or beyond it. `add` adds the ball to the world.
template <class Add>
void expect_none_pass(int aims, double rate_hz, double give_m, const Add& add) {
  int passed = 0, missed = 0;
  double deepest_m = INFINITY;
  for (int aim = 0; aim < aims; ++aim) {
    World world = world_at(rate_hz, 4, Vector3d::Zero());
    world.add_collider(Collider{BoxShape{{1.0, 1.0, 0.005}}, Pose{}, 0.3, 0.0});
    const double speed = 1.0 + 99.0 * aim / (aims - 1.0);
    const Vector3d target(0.3 * std::sin(1.7 * aim), 0.3 * std::cos(2.3 * aim), 0);
    const Vector3d from(0.4 * std::sin(0.7 * aim), 0.4 * std::cos(1.1 * aim),
                        0.5 + 0.3 * std::sin(3.1 * aim));
    const Vector3d velocity = speed * (target - from).normalized();
    add(world, from, velocity);
    const double energy = world.energy().kinetic_j;
    const int ticks = static_cast<int>(rate_hz * ((target - from).norm() / speed + 0.2));
    Vector3d before = from;
    bool through = false;
    for (int i = 0; i < ticks; ++i) {
      world.step();
      const Vector3d now = body_state(world, 1).world_from_body.position_m;
      // The point where the path crosses the plate's middle plane.
      if (before.z() > 0.0 && now.z() <= 0.0) {
        const Vector3d at = before + before.z() / (before.z() - now.z()) * (now - before);
        through = through || (std::abs(at.x()) < 0.5 && std::abs(at.y()) < 0.5);
      }
      if (std::abs(now.x()) < 0.5 && std::abs(now.y()) < 0.5) deepest_m = std::min(deepest_m, now.z());
      before = now;
    }
    passed += through;
    missed += (body_state(world, 1).velocity_m_s - velocity).norm() < 0.1 * speed;
    EXPECT_LE(world.energy().kinetic_j, energy * (1.0 + 1e-9));
  }
  EXPECT_EQ(passed, 0) << rate_hz;
  EXPECT_EQ(missed, 0) << rate_hz;
  // half the plate thickness plus the radius
  EXPECT_GT(deepest_m, 0.0025 + kFastRadius_m - give_m) << rate_hz;
}

TEST(RigidContact, FastBallDoesNotPassAPlate) {
  for (const double rate_hz : kRates_hz) {
    expect_none_pass(1000, rate_hz, 1e-4, [](World& world, const Vector3d& from, const Vector3d& velocity) {
      auto description = ball(1, from, kFastRadius_m);
      description.velocity_m_s = velocity;
      ASSERT_TRUE(world.add_ball(description));
    });
  }
}

// The mesh may lie on its facets, 0.3 % of the radius inside the sphere; a spinning one is held by its
// inscribed ball.
TEST(RigidContact, FastMeshDoesNotPassAPlate) {
  for (const double rate_hz : kRates_hz) {
    auto description = body_of(1, sphere_mesh(kFastRadius_m, 3), 0.5);
    expect_none_pass(20, rate_hz, 1e-3, [&](World& world, const Vector3d& from, const Vector3d& velocity) {
      description.world_from_object.position_m = from;
      description.velocity_m_s = velocity;
      ASSERT_TRUE(world.add_rigid(description));
    });
  }
}

TEST(RigidContact, FastBoxDoesNotPassAPlate) {
  int passed = 0;
  for (const double rate : kRates_hz)
    for (int aim = 0; aim < 40; ++aim) {
      World world = world_at(rate, 4, Vector3d::Zero());
      world.add_collider(Collider{BoxShape{{2.0, 2.0, 0.005}}, Pose{}, 0.3, 0.0});
      auto box = box_body(1, {0.1, 0.1, 0.1}, 0.5);
      box.world_from_object.position_m = {0.1 * std::sin(1.0 * aim), 0, 0.6};
      box.world_from_object.orientation = rotation_about(aim);
      box.velocity_m_s = {0, 0, -1.0 - aim};
      ASSERT_TRUE(world.add_rigid(box));
      run_seconds(world, 0.7);
      if (body_state(world, 1).world_from_body.position_m.z() < 0.02) ++passed;
    }
  EXPECT_EQ(passed, 0);
}

TEST(RigidContact, ContactPointsKeepCornersAndCoverEdges) {
  const RigidShape shape = mesh_shape(box_mesh({0.2, 0.1, 0.05}), Vector3d::Zero());
  EXPECT_LE(shape.contact_points_m.size(), kMaxContactPoints);
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3d expected(corner & 1 ? 0.1 : -0.1, corner & 2 ? 0.05 : -0.05, corner & 4 ? 0.025 : -0.025);
    double nearest = 1.0;
    for (const Vector3d& point : shape.contact_points_m)
      nearest = std::min(nearest, (point - expected).norm());
    EXPECT_EQ(nearest, 0.0);
  }
  // Along an edge no gap is wider than two spacings: if one point is removed, the next must stay.
  for (double x = -0.1; x <= 0.1; x += 0.005) {
    double nearest = 1.0;
    for (const Vector3d& point : shape.contact_points_m) {
      nearest = std::min(nearest, (point - Vector3d(x, 0.05, 0.025)).norm());
    }
    EXPECT_LT(nearest, shape.contact_spacing_m);
  }
}

}  // namespace
}  // namespace livegs
