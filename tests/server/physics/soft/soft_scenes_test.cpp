// SPDX-License-Identifier: Apache-2.0
// Scenes of elastic and rigid bodies on each other: they come to rest, sleep, wake, and do not pass through
// each other.
#include <bit>

#include "baseline/elastic_solvers.h"
#include "core/parallel_for.h"
#include "known_gaps.h"
#include "server/physics/soft/soft_depth.h"

namespace livegs {
namespace {

using namespace soft_fixtures;
using Eigen::Vector2d;

// Two soft cubes of 0.1 m and 0.5 kg on a floor, with the centre of the upper one at `high_m`.
World two_cubes(double rate, const Vector3d& high_m, double loss_factor, double spacing_m = 0.0125,
                double cell_width_m = 0.0) {
  World world = world_with(make_elastic_body, rate);
  world.add_collider(floor_plane(0.6));
  for (const uint32_t id : {1u, 2u}) {
    ElasticBodyDescription cube =
        soft_block(id, Vector3d::Constant(0.1), 0.5, 3e4, spacing_m, 0.3, cell_width_m);
    cube.material.loss_factor = loss_factor;
    cube.world_from_object.position_m = id == 1 ? Vector3d(0, 0.05, 0) : high_m;
    EXPECT_TRUE(world.add_elastic(cube));
  }
  return world;
}

void expect_stacked(const World& world, double shift_m, double rate) {
  const Vector3d top = world.elastic_body(2)->centre_m(), bottom = world.elastic_body(1)->centre_m();
  EXPECT_NEAR(bottom.y(), 0.05, 0.005) << rate;
  EXPECT_NEAR((top - bottom).y(), 0.1, 0.005) << rate;
  EXPECT_LT(Vector2d(top.x() - bottom.x(), top.z() - bottom.z()).norm(), shift_m) << rate;
  EXPECT_TRUE(world.elastic_body(1)->asleep() && world.elastic_body(2)->asleep()) << rate;
}

TEST(SoftScenes, SoftCubeDroppedOnAnotherStaysThere) {
  for (const double rate : kRates_hz) {
    World world = two_cubes(rate, {0, 0.17, 0}, 0.3);
    run_seconds(world, 5.0);
    expect_stacked(world, 0.002, rate);
  }
}

// An off-centre impact tilts the compressed lower cube, which throws the upper one sideways. The effect is
// elastic, independent of friction, and hardly depends on the cell width.
TEST(SoftScenes, OffCentreThrowMatchesFinerCells) {
  const auto thrown = [](double rate, double spacing_m, double cell_width_m) {
    World world = two_cubes(rate, {0.01, 0.17, 0.005}, 0.3, spacing_m, cell_width_m);
    run_seconds(world, 0.16);  // in the air again
    return world.elastic_body(2)->velocity_m_s().x();
  };
  const double converged = thrown(60.0, 0.00625, 0.0125);
  EXPECT_NEAR(converged, 0.1, 0.01);
  for (const double rate : kRates_hz) EXPECT_NEAR(thrown(rate, 0.0125, 0.0) / converged, 1.0, 0.1) << rate;
}

// The cube bounces a few times and comes to rest slightly further out.
TEST(SoftScenes, OffCentreCubeStaysOnTheOther) {
  for (const double rate : kRates_hz) {
    World world = two_cubes(rate, {0.01, 0.17, 0.005}, 0.3);
    run_seconds(world, 6.0);
    expect_stacked(world, 0.04, rate);  // the start offset is 0.011 m
  }
}

// A block on another stands if its centre of mass lies above it, and falls if not, whichever of the two lists
// its contacts first.
TEST(SoftScenes, BlockStandsUpToTheEdgeOfAnother) {
  for (const double spacing_of_upper_m : {0.0125, 0.025}) {
    for (const double overhang_m : {0.045, 0.055}) {
      World world = world_with(make_elastic_body, 90.0);
      world.add_collider(floor_plane(0.6));
      ElasticBodyDescription lower = soft_block(1, {0.1, 0.1, 0.1}, 1.0, 1e6, 0.0125);
      lower.world_from_object.position_m.y() = 0.05;
      ASSERT_TRUE(world.add_elastic(lower));
      ElasticBodyDescription upper = soft_block(2, {0.1, 0.05, 0.1}, 0.5, 1e6, spacing_of_upper_m);
      upper.world_from_object.position_m = {overhang_m, 0.125, 0.0};
      ASSERT_TRUE(world.add_elastic(upper));
      run_seconds(world, 4.0);
      const double height_m = world.elastic_body(2)->centre_m().y();
      if (overhang_m < 0.05)
        EXPECT_GT(height_m, 0.12) << spacing_of_upper_m;
      else
        EXPECT_LT(height_m, 0.1) << spacing_of_upper_m;
    }
  }
}

// The amplitude of a spring with a loss factor eta falls to exp(-pi eta / 2) in half a cycle, at any load.
TEST(SoftScenes, LossFactorIsIndependentOfLoad) {
  for (const double loss_factor : {0.1, 0.3}) {
    for (const double mass_kg : {2.0, 5.0}) {
      if (loss_factor > 0.2 && mass_kg < 3.0) continue;
      World world = world_with(make_elastic_body, 90.0);
      world.add_collider(floor_plane(0.6));
      ElasticBodyDescription block = soft_block(1, Vector3d::Constant(0.1), 0.2, 1e5, 0.0125);
      block.material.loss_factor = loss_factor;
      block.world_from_object.position_m = {0, 0.05, 0};
      ASSERT_TRUE(world.add_elastic(block));
      RigidBodyDescription box = box_body(2, {0.12, 0.05, 0.12}, mass_kg);
      box.world_from_object.position_m = {0, 0.125, 0};
      ASSERT_TRUE(world.add_rigid(box));
      std::vector<double> heights;
      for (int i = 0; i < 120; ++i) {
        world.step();
        heights.push_back(body_state(world, 2).world_from_body.position_m.y());
      }
      std::vector<double> swings;
      for (size_t i = 1; i + 1 < heights.size(); ++i) {
        const bool turns = (heights[i] - heights[i - 1]) * (heights[i + 1] - heights[i]) <= 0.0;
        if (turns) swings.push_back(std::abs(heights[i] - heights.back()));
      }
      ASSERT_GT(swings.size(), 5u);
      const double lost = std::log(swings[0] / swings[4]) / (2.0 * M_PI * loss_factor);
      report_gap("soft.loss_under_load", lost);
      EXPECT_LT(lost, 1.1) << loss_factor << " " << mass_kg;
    }
  }
}

// A sheet of 0.7 m and 30 mm that is held along its four edges, and a ball laid on its middle. The ball comes
// to rest there within the time that the loss factor gives: the sheet's lowest mode falls by exp(-pi eta / 2)
// in half a cycle, below 4 Hz.
TEST(SoftScenes, BallRestsOnTheMiddleOfAHeldSheet) {
  for (const double mass_kg : {0.5, 2.0, 5.0}) {
    for (const double rate : kRates_hz) {
      SCOPED_TRACE(testing::Message() << mass_kg << " kg, " << rate << " Hz");
      World world = world_with(make_elastic_body, rate);
      ElasticBodyDescription sheet = soft_block(1, {0.7, 0.03, 0.7}, 1.47, 1e6, 0.03);
      sheet.material.loss_factor = 0.5;
      for (const double side : {-1.0, 1.0}) {
        for (const int axis : {0, 2}) {
          BodyRegion edge;
          edge.min_m = Vector3d::Constant(-1.0);
          edge.max_m = Vector3d::Constant(1.0);
          (side < 0.0 ? edge.max_m : edge.min_m)[axis] = side * 0.3;
          edge.fixed = true;
          sheet.regions.push_back(edge);
        }
      }
      ASSERT_TRUE(world.add_elastic(sheet));
      BallDescription ball;
      ball.object_id = 2;
      ball.position_m = {0, 0.095, 0};
      ball.radius_m = 0.08;
      ball.mass_kg = mass_kg;
      ASSERT_TRUE(world.add_ball(ball));
      run_seconds(world, 3.0);
      const Vector3d at_3_s = body_state(world, 2).world_from_body.position_m;
      double swing_m = 0.0;
      for (int i = 0; i < static_cast<int>(rate); ++i) {
        world.step();
        swing_m =
            std::max(swing_m, std::abs(body_state(world, 2).world_from_body.position_m.y() - at_3_s.y()));
      }
      EXPECT_LT(swing_m, 0.001);
      const Vector3d rest = body_state(world, 2).world_from_body.position_m;
      EXPECT_LT(std::hypot(rest.x(), rest.z()), 0.005);
      EXPECT_GT(rest.y(), 0.02);
    }
  }
}

void add_table_scene(World& world) {
  world.add_collider(floor_plane(0.6));
  RigidBodyDescription table = box_body(1, {0.6, 0.06, 0.4}, 6.0);
  table.world_from_object.position_m = {0, 0.03, 0};
  EXPECT_TRUE(world.add_rigid(table));
  ElasticBodyDescription cube = soft_block(2, Vector3d::Constant(0.1), 0.4, 3e4, 0.0125);
  cube.world_from_object.position_m = {0, 0.13, 0};
  EXPECT_TRUE(world.add_elastic(cube));
  RigidBodyDescription box = box_body(3, {0.08, 0.06, 0.07}, 0.5);
  box.world_from_object.position_m = {0.01, 0.26, 0};
  box.world_from_object.orientation = rotation_about(1);
  EXPECT_TRUE(world.add_rigid(box));
}

TEST(SoftScenes, SoftCubeAndTiltedBoxRestOnATable) {
  for (const double rate : kRates_hz) {
    World world = world_with(make_elastic_body, rate);
    add_table_scene(world);
    run_seconds(world, 5.0);
    const double cube = world.elastic_body(2)->centre_m().y(),
                 box = body_state(world, 3).world_from_body.position_m.y();
    EXPECT_NEAR(cube, 0.11, 0.006);               // the sag of 0.9 kg on 0.01 m² is under 3 %
    EXPECT_GT(lowest_m(world, 2), 0.06 + 0.005);  // centres of voxels of 12.5 mm, squeezed
    EXPECT_GT(box, 0.06 + 0.025);                 // on the cube, or next to it on the table
    EXPECT_NEAR(body_state(world, 1).world_from_body.position_m.y(), 0.03, 1e-3);
    EXPECT_TRUE(world.elastic_body(2)->asleep());
    EXPECT_TRUE(body_state(world, 1).asleep && body_state(world, 3).asleep);
  }
}

// A jelly cube that its own weight compresses by a quarter. A folded corner snaps back and forth and must not
// keep the cube and the table awake.
TEST(SoftScenes, JellyCubeSleepsOnAMovableTable) {
  for (const double rate : kRates_hz) {
    World world = world_with(make_elastic_body, rate);
    world.add_collider(floor_plane(0.6));
    RigidBodyDescription table = box_body(1, {0.8, 0.02, 0.5}, 3.0);
    table.world_from_object.position_m = {0, 0.01, 0};
    ASSERT_TRUE(world.add_rigid(table));
    ElasticBodyDescription cube = soft_block(2, Vector3d::Constant(0.1), 1.0, 2e3, 0.02, 0.45);
    cube.particles = sample_particles(box_mesh(Vector3d::Constant(0.1)), kDefaultSamplingDensity);
    cube.material.loss_factor = 0.2;
    cube.world_from_object.position_m = {0.03, 0.071, 0.02};
    ASSERT_TRUE(world.add_elastic(cube));
    int ticks = 0;
    for (; ticks < 20 * rate && !(world.elastic_body(2)->asleep() && body_state(world, 1).asleep); ++ticks)
      world.step();
    EXPECT_LT(ticks, 3 * rate) << rate;
    EXPECT_NEAR(world.elastic_body(2)->centre_m().x(), 0.03, 0.002);
    EXPECT_NEAR(world.elastic_body(2)->centre_m().z(), 0.02, 0.002);
  }
}

// The rod is thinner than half the spacing of the block's points, so its own points must make contact. A line
// load has no closed form here; the reference is the depth in the finest cells, including the block's own
// sag.
TEST(SoftScenes, ThinRodRestsAcrossASoftBlock) {
  constexpr double kSunk_m = 1.71e-3;
  struct Case {
    double rate, cell_width_m;
  };
  std::vector<Case> cases;
  for (const double rate : kRates_hz) cases.insert(cases.end(), {{rate, 0.0}, {rate, 0.025}});
  for (const Case& c : cases) {
    World world = world_with(make_elastic_body, c.rate);
    world.add_collider(floor_plane(0.6));
    ElasticBodyDescription block = soft_block(1, {0.2, 0.1, 0.2}, 1.0, 3e4, 0.025, 0.3, c.cell_width_m);
    block.world_from_object.position_m = {0, 0.05, 0};
    ASSERT_TRUE(world.add_elastic(block));
    RigidBodyDescription rod = box_body(2, {0.4, 0.01, 0.01}, 0.4);
    rod.world_from_object.position_m = {0, 0.12, 0.007};
    ASSERT_TRUE(world.add_rigid(rod));
    run_seconds(world, 5.0);
    const BodyState state = body_state(world, 2);
    report_gap("soft.rod_depth", std::abs((0.105 - state.world_from_body.position_m.y()) / kSunk_m - 1.0));
    EXPECT_TRUE(state.asleep && world.elastic_body(1)->asleep());
  }
}

TEST(SoftScenes, PileOfEightStaysAboveTheFloor) {
  World world = world_with(make_elastic_body, 60.0);
  world.add_collider(floor_plane(0.6));
  for (uint32_t i = 0; i < 8; ++i) {
    ElasticBodyDescription soft = soft_block(1 + i, {0.12, 0.08, 0.1}, 0.4, 2e4, 0.02);
    soft.world_from_object.position_m = {0.05 * (i % 2) - 0.03 * (i % 3), 0.1 + 0.13 * i, 0.02 * (i % 3)};
    soft.world_from_object.orientation = rotation_about(static_cast<int>(i));
    ASSERT_TRUE(world.add_elastic(soft));
  }
  const BodyEnergy start = world.energy();
  double peak = -1e300, low = 1.0;
  for (int i = 0; i < 600; ++i) {
    world.step();
    if (i % 10) continue;
    const BodyEnergy now = world.energy();
    peak = std::max(peak, now.kinetic_j + now.elastic_j + now.gravity_j - start.kinetic_j - start.elastic_j -
                              start.gravity_j);
    for (uint32_t id = 1; id <= 8; ++id) low = std::min(low, lowest_m(world, id));
  }
  for (uint32_t id = 1; id <= 8; ++id) EXPECT_TRUE(test::all_finite(*world.elastic_body(id)));
  EXPECT_LT(peak, 0.01 * start.gravity_j);
  EXPECT_GT(low, 0.0);
  EXPECT_LT(world.energy().kinetic_j, 1e-3);
}

// Free and fixed plates. A free plate hit off its centre rotates, so it is checked before it has turned over.
TEST(SoftScenes, SoftBodiesThrownAtPlatesDoNotPass) {
  int passed = 0, runs = 0;
  for (const bool fixed : {false, true}) {
    for (const double speed : gate_or_full<double>({1.0, 20.0}, {1.0, 5.0, 10.0, 20.0})) {
      for (const double thickness : {0.005, 0.02}) {
        for (const double rate : kRates_hz)
          for (int aim = 0; aim < 3; ++aim) {
            World world = world_with(make_elastic_body, rate, Vector3d::Zero());
            if (fixed) {
              Collider plate;
              plate.shape = BoxShape{{0.3, 0.3, thickness}};
              world.add_collider(plate);
            } else {
              ASSERT_TRUE(world.add_rigid(box_body(1, {0.3, 0.3, thickness}, 2.0)));
            }
            ElasticBodyDescription cube = soft_block(2, Vector3d::Constant(0.08), 0.1, 3e4, 0.016);
            cube.world_from_object.position_m = {0.02 - 0.03 * aim, 0.03 - 0.05 * aim, 0.2};
            cube.world_from_object.orientation = rotation_about(2 + aim);
            cube.velocity_m_s = {0, 0, -speed};
            ASSERT_TRUE(world.add_elastic(cube));
            bool through = false;
            for (int i = 0; i < (0.2 + 0.3 / speed) * rate; ++i) {
              world.step();
              const Pose plate = fixed ? Pose{} : body_state(world, 1).world_from_body;
              const Vector3d seen = plate.inverse() * world.elastic_body(2)->centre_m();
              through = through || ((plate.orientation * Vector3d::UnitZ()).z() > 0.5 && seen.z() < 0.0);
            }
            ++runs;
            passed += through;
          }
      }
    }
  }
  EXPECT_EQ(passed, 0) << "of " << runs;
}

// After a pull of 0.1 s both bodies sleep again within 3 s, in the same tick, as soon as the soft body alone
// would.
TEST(SoftScenes, PulledPairSleepsAgainWithinThreeSeconds) {
  for (const double rate : kRates_hz) {
    World world = world_with(make_elastic_body, rate);
    world.add_collider(floor_plane(0.6));
    ElasticBodyDescription pillow = soft_block(1, {0.2, 0.06, 0.2}, 0.4, 3e4, 0.02);
    pillow.world_from_object.position_m = {0, 0.031, 0};
    ASSERT_TRUE(world.add_elastic(pillow));
    RigidBodyDescription box = box_body(2, Vector3d::Constant(0.08), 0.5);
    box.world_from_object.position_m = {0, 0.105, 0};
    ASSERT_TRUE(world.add_rigid(box));
    run_seconds(world, 5.0);
    ASSERT_TRUE(body_state(world, 2).asleep && world.elastic_body(1)->asleep()) << rate;
    world.set_force(1, 2, {{0, 0, 0}, {2, 0, 0}}, 0.1);
    run_seconds(world, 0.1);
    EXPECT_FALSE(world.elastic_body(1)->asleep());
    int ticks = 0;
    while (!world.elastic_body(1)->asleep() && ticks < 10 * rate) {
      world.step();
      ++ticks;
      EXPECT_EQ(world.elastic_body(1)->asleep(), body_state(world, 2).asleep);
    }
    EXPECT_LT(ticks / rate, 3.0) << rate;
  }
}

TEST(SoftScenes, RigidBoxSleepsAndWakesWithSoftBody) {
  for (const ElasticBodyFactory solver : {make_elastic_body, make_livegs_v1_body}) {
    World world = world_with(solver, 90.0);
    world.add_collider(floor_plane(0.6));
    ElasticBodyDescription pillow =
        soft_block(1, {0.2, 0.06, 0.2}, 0.4, solver == make_elastic_body ? 3e4 : 3e6, 0.02);
    pillow.material.loss_factor = 1.0;
    pillow.world_from_object.position_m = {0, 0.031, 0};
    ASSERT_TRUE(world.add_elastic(pillow));
    RigidBodyDescription box = box_body(2, Vector3d::Constant(0.08), 0.5);
    box.world_from_object.position_m = {0, 0.105, 0};
    ASSERT_TRUE(world.add_rigid(box));
    double struck_soft = 0.0, struck_box = 0.0;
    for (int i = 0; i < 540; ++i) {
      world.step();
      for (const WorldEvent& event : world.take_events()) {
        if (event.kind != WorldEventKind::Contact) continue;
        (event.object_id == 1 ? struck_soft : struck_box) += event.impulse_n_s;
      }
    }
    EXPECT_TRUE(body_state(world, 2).asleep);
    EXPECT_TRUE(world.elastic_body(1)->asleep());
    EXPECT_GT(struck_soft, 0.1);
    EXPECT_GT(struck_box, 0.1);

    // A pull on the box wakes both. 2 N do not lift it.
    world.set_force(1, 2, {{0, 0, 0}, {2, 0, 0}}, 2.0 / 90.0);
    run_seconds(world, 2.0 / 90.0);
    EXPECT_FALSE(body_state(world, 2).asleep);
    EXPECT_FALSE(world.elastic_body(1)->asleep());
    run_seconds(world, 4.0);
    report_gap("soft.asleep_after_pull", body_state(world, 2).asleep && world.elastic_body(1)->asleep());
    // Without the box the block rises again.
    world.remove(2);
    world.step();
    EXPECT_FALSE(world.elastic_body(1)->asleep());
  }
}

TEST(SoftScenes, SleepingSoftBodyWakesWhenABoxLandsOnIt) {
  World world = world_with(make_elastic_body, 90.0);
  world.add_collider(floor_plane(0.6));
  ElasticBodyDescription pillow = soft_block(1, {0.2, 0.06, 0.2}, 0.4, 3e4, 0.02);
  pillow.world_from_object.position_m = {0, 0.03, 0};
  ASSERT_TRUE(world.add_elastic(pillow));
  run_seconds(world, 3.0);
  ASSERT_TRUE(world.elastic_body(1)->asleep());
  const double before = world.elastic_body(1)->centre_m().y();
  RigidBodyDescription box = box_body(2, Vector3d::Constant(0.08), 2.0);
  box.world_from_object.position_m = {0, 0.3, 0};
  ASSERT_TRUE(world.add_rigid(box));
  run_seconds(world, 0.1);
  EXPECT_TRUE(world.elastic_body(1)->asleep()) << "woke before the box landed";
  run_seconds(world, 0.15);
  EXPECT_FALSE(world.elastic_body(1)->asleep());
  double lowest = before;  // the box bounces
  for (int i = 0; i < 45; ++i) {
    world.step();
    lowest = std::min(lowest, world.elastic_body(1)->centre_m().y());
  }
  EXPECT_LT(lowest, before - 5e-4);
}

uint64_t hash_of(const World& world) {
  uint64_t hash = 0xcbf29ce484222325u;
  const auto mix = [&](double value) { hash = (hash ^ std::bit_cast<uint64_t>(value)) * 0x100000001b3u; };
  for (const ObjectDrivers& object : world.drivers().objects) {
    for (const Pose& pose : object.poses) {
      for (int i = 0; i < 3; ++i) mix(pose.position_m[i]);
      for (int i = 0; i < 4; ++i) mix(pose.orientation.coeffs()[i]);
    }
    for (const Eigen::Vector3f& node : object.positions_m) {
      for (int i = 0; i < 3; ++i) mix(node[i]);
    }
  }
  return hash;
}

TEST(SoftScenes, SameBitsForAnyNumberOfThreads) {
  std::vector<uint64_t> hashes;
  for (const int threads : {1, 2, 8}) {
    set_thread_count(threads);
    World world = world_with(make_elastic_body, 90.0);
    add_table_scene(world);
    for (uint32_t i = 0; i < 4; ++i) {
      ElasticBodyDescription soft = soft_block(10 + i, {0.1, 0.06, 0.08}, 0.3, 2e4, 0.02);
      soft.world_from_object.position_m = {0.25 * i - 0.4, 0.2 + 0.03 * i, i < 2 ? 0.0 : 0.5};
      ASSERT_TRUE(world.add_elastic(soft));
      ASSERT_TRUE(world.add_ball(ball(30 + i, {0.25 * i - 0.4, 0.4, i < 2 ? 0.0 : 0.5}, 0.03, 0.2)));
    }
    for (int i = 0; i < 150; ++i) world.step();
    hashes.push_back(hash_of(world));
  }
  set_thread_count(0);
  EXPECT_EQ(hashes[0], hashes[1]);
  EXPECT_EQ(hashes[0], hashes[2]);
}

// A heap, whose contacts are swept on several threads; with and without a rigid body.
TEST(SoftScenes, HeapHasTheSameBitsForAnyNumberOfThreads) {
  for (const bool with_ball : {false, true}) {
    std::vector<uint64_t> hashes;
    for (const int threads : {1, 2, 8}) {
      set_thread_count(threads);
      World world = world_with(make_elastic_body, 90.0);
      world.add_collider(floor_plane(0.6));
      for (uint32_t i = 0; i < 24; ++i) {
        ElasticBodyDescription box = soft_block(1 + i, {0.2, 0.15, 0.2}, 1.8, 3e4, 0.025);
        box.world_from_object.position_m = {0.21 * (i % 3), 0.08 + 0.16 * (i / 6), 0.21 * (i / 3 % 2)};
        ASSERT_TRUE(world.add_elastic(box));
      }
      if (with_ball) ASSERT_TRUE(world.add_ball(ball(40, {0.2, 0.8, 0.1}, 0.05, 2.0)));
      for (int i = 0; i < 40; ++i) world.step();
      hashes.push_back(hash_of(world));
    }
    set_thread_count(0);
    EXPECT_EQ(hashes[0], hashes[1]) << with_ball;
    EXPECT_EQ(hashes[0], hashes[2]) << with_ball;
  }
}

// Blocks that start within each other, without gravity, separate slowly: their energy stays below half a per
// cent of m g L of one of them, with its reach L.
TEST(SoftScenes, OverlappingBlocksSeparateSlowly) {
  const Vector3d size_m(0.2, 0.15, 0.2);
  for (const double rate : kRates_hz) {
    for (const Vector3d& at_m : {Vector3d(0.19, 0.05, 0.0), {0.18, 0.14, 0.02}, {0.05, 0.12, 0.03}}) {
      for (const double youngs_modulus_pa : {3e3, 3e4, 3e5}) {
        SCOPED_TRACE(testing::Message() << rate << ' ' << at_m.transpose() << ", " << youngs_modulus_pa);
        World world = world_with(make_elastic_body, rate, Vector3d::Zero());
        for (uint32_t i = 0; i < 2; ++i) {
          ElasticBodyDescription box = soft_block(1 + i, size_m, 1.8, youngs_modulus_pa, 0.025);
          box.world_from_object.position_m = i * at_m;
          ASSERT_TRUE(world.add_elastic(box));
        }
        double most_j = 0.0;
        for (int i = 0; i < static_cast<int>(3.0 * rate); ++i) {
          world.step();
          const BodyEnergy energy = world.energy();
          most_j = std::max(most_j, energy.kinetic_j + energy.elastic_j);
        }
        EXPECT_LT(most_j, 0.005 * 1.8 * kGravity * 0.5 * size_m.norm());
        const Vector3d apart_m = world.elastic_body(2)->centre_m() - world.elastic_body(1)->centre_m();
        EXPECT_GT((apart_m.cwiseAbs() - size_m).maxCoeff(), -0.002);
      }
    }
  }
}

}  // namespace
}  // namespace livegs
