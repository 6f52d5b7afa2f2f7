// SPDX-License-Identifier: Apache-2.0
// Sustained loads (weights, stacks, pressing hands) are not impacts, at any tick rate. Impacts transmitted
// through other bodies are impacts.
#include <algorithm>
#include <array>

#include "known_gaps.h"
#include "physics/rigid/contact/impact_record.h"
#include "scenes/break_fixtures.h"

namespace livegs {
namespace {

using namespace break_fixtures;

constexpr int kSubsteps[] = {1, 2, 4, 8, 16, 32};
constexpr uint32_t kWeight = 7;

// A weight 0.01 mm above a cup that is on the floor.
World weighed(double rate, int substeps, double kg) {
  World world = with_cup(cup_at(0.0), world_at(rate, substeps));
  world.add_collider(floor_plane());
  RigidBodyDescription weight = box_body(kWeight, {0.2, 0.05, 0.2}, kg);
  weight.world_from_object.position_m = {0, 0.1 + 0.025 + 1e-5, 0};
  EXPECT_TRUE(world.add_rigid(weight));
  return world;
}

// A mass of 10 kg presses with 98 N. In 1 ms that is 0.098 N s, one seventh of the break impulse of 0.7 N s.
// The load must not be accumulated over a tick. At one substep of 60 Hz the mass of 10 kg slides off, which
// does not break the cup either.
TEST(BreakingLoads, RestingWeightBreaksNothing) {
  for (const double rate : kRates_hz) {
    for (const int substeps : kSubsteps) {
      SCOPED_TRACE(::testing::Message() << substeps << " substeps of " << rate << " Hz");
      World world = weighed(rate, substeps, substeps == 1 ? 4.0 : 10.0);
      run_seconds(world, 5.0);
      EXPECT_EQ(world.revision(kCup), 0u);
      // Few substeps let the weight sink further into the contact.
      EXPECT_NEAR(body_state(world, kWeight).world_from_body.position_m.y(), 0.125,
                  substeps < 4 ? 0.0025 : 0.0004);
    }
  }
}

// A force breaks the cup like an impact of that force over kImpactDuration_s. The cup is pressed from both
// sides, and both count. At least 4 substeps: with fewer, a force of 140 times its weight moves the cup into
// the floor before the first contact carries it.
TEST(BreakingLoads, CrushingForceIsTheSameAtAnyRate) {
  const double crushing_n = 0.5 * kBreakImpulse_n_s / kImpactDuration_s;
  for (const double rate : {60.0, 90.0}) {
    for (const int substeps : {4, 8, 16, 32}) {
      SCOPED_TRACE(::testing::Message() << substeps << " substeps of " << rate << " Hz");
      const auto crushed_by = [&](double newton) {
        World world = with_cup(cup_at(0.0), world_at(rate, substeps));
        world.add_collider(floor_plane());
        run_seconds(world, 0.5);
        world.set_force(3, kCup, {{0, 0.05, 0}, {0, -newton, 0}});
        run_seconds(world, 0.5);
        return world.revision(kCup) > 0;
      };
      EXPECT_FALSE(crushed_by(0.97 * crushing_n - kMass_kg * kGravity));
      EXPECT_TRUE(crushed_by(1.03 * crushing_n));
    }
  }
}

TEST(BreakingLoads, StackOfTwelvePlatesStaysWhole) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    World world = world_at(rate, 4);
    world.add_collider(floor_plane());
    const TriangleMesh plate = box_mesh({0.24, 0.012, 0.24});
    const auto pieces = pieces_of(plate, 12, 3);
    for (uint32_t i = 0; i < 12; ++i) {
      RigidBodyDescription one = body_of(kCup + i, plate, 0.4);
      one.material.fragile = true;
      one.material.break_impulse_n_s = 1.2;  // a fall of 0.32 m at a restitution of 0.2
      one.world_from_object.position_m = {0.002 * (i % 3), 0.006 + 0.0122 * i, 0.003 * (i % 2)};
      ASSERT_TRUE(world.add_rigid(one));
      ASSERT_TRUE(world.set_pieces(kCup + i, pieces));
    }
    run_seconds(world, 5.0);
    for (uint32_t i = 0; i < 12; ++i) EXPECT_EQ(world.revision(kCup + i), 0u) << i;
    for (const BodyState& body : world.bodies()) EXPECT_TRUE(body.asleep) << body.object_id;
    // Another plate dropped from half a metre breaks the top one.
    RigidBodyDescription last = body_of(kCup + 20, plate, 0.4);
    last.world_from_object.position_m = {0, 0.65, 0};
    ASSERT_TRUE(world.add_rigid(last));
    run_seconds(world, 1.0);
    EXPECT_GT(world.revision(kCup + 11), 0u);
  }
}

// A weight falls onto a sleeping cup on the floor. Loads before and after the impact within the tick do not
// count, so the height hardly depends on the number of substeps.
TEST(BreakingLoads, WeightBreaksCupFromOneHeight) {
  const auto breaks = [](double rate, int substeps, double fall_m) {
    World world = with_cup(cup_at(0.0), world_at(rate, substeps));
    world.add_collider(floor_plane());
    run_seconds(world, 1.0);
    RigidBodyDescription weight = box_body(kWeight, {0.2, 0.05, 0.2}, kMass_kg);
    weight.world_from_object.position_m = {0, 0.125 + fall_m, 0};
    EXPECT_TRUE(world.add_rigid(weight));
    run_seconds(world, std::sqrt(2 * fall_m / kGravity) + 0.05);
    return world.revision(kCup) > 0;
  };
  // The impulse passes between weight, cup and floor until no contact closes any more; at e = 0.2 and equal
  // masses the cup receives 0.6 + 0.72 + 0.312 + ... = 1.995 m v in all. The bounds contain the scatter from
  // the position of the landing within a substep.
  constexpr double kSpeed_m_s = kBreakImpulse_n_s / (1.995 * kMass_kg);
  constexpr double kHeight_m = kSpeed_m_s * kSpeed_m_s / (2.0 * kGravity);
  for (const double rate : kRates_hz) {
    for (const int substeps : kSubsteps) {
      SCOPED_TRACE(::testing::Message() << substeps << " substeps of " << rate << " Hz");
      double held = 0.84, broken = substeps == 1 ? 1.2 : 1.16;
      EXPECT_FALSE(breaks(rate, substeps, held * kHeight_m));
      EXPECT_TRUE(breaks(rate, substeps, broken * kHeight_m));
      for (int i = 0; i < 5; ++i) {
        const double share = 0.5 * (held + broken);
        (breaks(rate, substeps, share * kHeight_m) ? broken : held) = share;
      }
      report_gap("breaking.weight_height", std::abs(0.5 * (held + broken) - 1.0));
    }
  }
}

// Impacts of light bodies on a resting weight do not break the cup below it. 36 balls of 1 g fall from the
// first tick on; some hit the cup directly if the weight is 4 kg.
TEST(BreakingLoads, LightImpactsOnALoadBreakNothing) {
  for (const double rate : kRates_hz) {
    for (const int substeps : {4, 32}) {
      for (const double kg : {4.0, 10.0}) {
        SCOPED_TRACE(::testing::Message() << substeps << " substeps of " << rate << " Hz, " << kg << " kg");
        World world = weighed(rate, substeps, kg);
        for (uint32_t i = 0; i < 36; ++i) {
          ASSERT_TRUE(world.add_ball(ball(
              100 + i, {0.03 * (i % 6) - 0.075, 0.17 + 0.025 * i, 0.03 * (i / 6) - 0.075}, 0.008, 0.001)));
        }
        run_seconds(world, 1.0);
        EXPECT_EQ(world.revision(kCup), 0u);
      }
    }
  }
}

// A weight wakes the sleeping body that it hits, at any time within a substep.
TEST(BreakingLoads, ImpactAlwaysWakesSleepingCup) {
  for (const double rate : kRates_hz)
    for (const int substeps : {4, 32}) {
      for (int i = 0; i < 40; i += full_sets() ? 1 : 5) {
        SCOPED_TRACE(::testing::Message() << substeps << " substeps of " << rate << " Hz, " << i);
        World world = with_cup(cup_at(0.0), world_at(rate, substeps));
        world.add_collider(floor_plane());
        run_seconds(world, 1.0);
        ASSERT_TRUE(body_state(world, kCup).asleep);
        const double fall_m = 0.02 + 0.0013 * i;
        RigidBodyDescription weight = box_body(kWeight, {0.2, 0.05, 0.2}, kMass_kg);
        weight.world_from_object.position_m = {0, 0.125 + fall_m, 0};
        ASSERT_TRUE(world.add_rigid(weight));
        run_seconds(world, std::sqrt(2 * fall_m / kGravity) + 0.05);
        EXPECT_FALSE(body_state(world, kCup).asleep);
      }
    }
}

// A held fragment reports its own contact impulses, not those of the other fragments.
TEST(BreakingLoads, FragmentsReportTheirOwnImpulses) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    World world = with_cup(cup_at(0.0), world_at(rate, 4));
    world.add_collider(floor_plane());
    ASSERT_TRUE(world.break_object(kCup, {0.038, 0.05, 0}));
    const Vector3d held_at = cup_pieces()->cut.pieces[0].mass.centre_of_mass_m;
    ASSERT_TRUE(world.grab(1, kCup, {world.world_point(kCup, held_at), Eigen::Quaterniond::Identity()}, {}));
    world.move_grab(1, {{0, 0.6, 0}, Eigen::Quaterniond::Identity()}, Vector3d::Zero(), Vector3d::Zero());
    double held_n_s = 0.0;
    std::vector<double> mean_n_s(cup_pieces()->cut.pieces.size(), 0.0);
    const int first = static_cast<int>(rate / 2), ticks = static_cast<int>(rate);
    for (int tick = 0; tick < ticks; ++tick) {
      world.step();
      if (tick < first) continue;  // until the fragment is in the air
      held_n_s = std::max(held_n_s, world.contact_impulse_n_s(kCup, held_at));
      for (size_t i = 0; i < mean_n_s.size(); ++i) {
        const Vector3d& centre = cup_pieces()->cut.pieces[i].mass.centre_of_mass_m;
        mean_n_s[i] += world.contact_impulse_n_s(kCup, centre) / (ticks - first);
      }
    }
    const double most_n_s = *std::max_element(mean_n_s.begin(), mean_n_s.end());
    EXPECT_EQ(held_n_s, 0.0);
    EXPECT_GT(most_n_s, 0.0);
    // Contacts are mostly vertical: the others press on a fragment with at most their weight, and what bears
    // it pushes back with at most the whole weight. A mean, because fragments still rock.
    EXPECT_LT(most_n_s, 2.0 * kMass_kg * kGravity / rate);
  }
}

// A force that acts on a sleeping body is not accumulated until it wakes.
TEST(BreakingLoads, ForceOnSleepingBodyIsNotAccumulated) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    World world = with_cup(cup_at(0.0), world_at(rate, 4));
    world.add_collider(floor_plane());
    run_seconds(world, 0.5);
    world.set_force(3, kCup, {{0, 0.02, 0}, {1, 0, 0}}, 5.0);
    run_seconds(world, 5.0);
    ASSERT_TRUE(body_state(world, kCup).asleep);
    run_seconds(world, 0.5);
    EXPECT_EQ(world.revision(kCup), 0u);
  }
}

// Two hands, with grips or ray springs, break the cup at the same force as any other load. The impulses of
// both hands over kImpactDuration_s add up.
TEST(BreakingLoads, PullingHandsBreakAtTheForceThreshold) {
  const double tearing_n = 0.5 * kBreakImpulse_n_s / kImpactDuration_s;
  for (const double rate : kRates_hz) {
    for (const int substeps : {4, 32}) {
      for (const bool grips : {true, false}) {
        SCOPED_TRACE(::testing::Message()
                     << substeps << " substeps of " << rate << " Hz, " << (grips ? "grips" : "rays"));
        const auto torn_by = [&](double newton) {
          World world = with_cup(cup_at(0.0), world_at(rate, substeps, Vector3d::Zero()));
          for (uint64_t hand : {1, 2}) {
            const Vector3d side((hand == 1 ? 1 : -1) * 0.04, 0.05, 0), away = 4.0 * side;
            if (grips) {
              World::Grip grip;
              grip.frequency_hz = 60.0;
              grip.max_force_n = newton;
              EXPECT_TRUE(world.grab(hand, kCup, {side, Eigen::Quaterniond::Identity()}, grip));
              world.move_grab(hand, {{away.x(), side.y(), 0}, Eigen::Quaterniond::Identity()},
                              Vector3d::Zero(), Vector3d::Zero());
            } else {
              world.set_spring(hand, kCup, {side, {away.x(), side.y(), 0}, 1e5, newton});
            }
          }
          run_seconds(world, 0.2);
          return world.revision(kCup) > 0;
        };
        EXPECT_FALSE(torn_by(0.97 * tearing_n));
        EXPECT_TRUE(torn_by(1.03 * tearing_n));
        EXPECT_TRUE(torn_by(2000.0));
      }
    }
  }
}

// The load on a cup between a hook and a weight is the weight below plus the cup and the weight above.
TEST(BreakingLoads, HangingWeightBreaksCupAtTheForceThreshold) {
  const double tearing_kg = 0.5 * (kBreakImpulse_n_s / kImpactDuration_s / kGravity - kMass_kg);
  for (const double rate : kRates_hz) {
    for (const int substeps : {4, 32}) {
      SCOPED_TRACE(::testing::Message() << substeps << " substeps of " << rate << " Hz");
      const auto torn_by = [&](double kg) {
        World world = with_cup(cup_at(0.0), world_at(rate, substeps));
        RigidBodyDescription weight = box_body(kWeight, {0.2, 0.2, 0.2}, kg);
        weight.world_from_object.position_m = {0, -0.2, 0};
        EXPECT_TRUE(world.add_rigid(weight));
        EXPECT_TRUE(world.add_ball_joint({kCup, {}, {0, 0.1, 0}}));
        EXPECT_TRUE(world.add_ball_joint({kCup, kWeight, {0, 0.0, 0}}));
        run_seconds(world, 1.0);
        return world.revision(kCup) > 0;
      };
      EXPECT_FALSE(torn_by(0.97 * tearing_kg));
      EXPECT_TRUE(torn_by(1.03 * tearing_kg));
    }
  }
}

// The impulse that a joint transmits belongs to the impact, so the result does not depend on the substep.
TEST(BreakingLoads, HookedCupBreaksAtOneImpactSpeed) {
  const auto breaks = [](double rate, int substeps, double speed_m_s) {
    World world = with_cup(cup_at(0.0), world_at(rate, substeps));
    EXPECT_TRUE(world.add_ball_joint({kCup, {}, {0, 0.1, 0}}));
    BallDescription shot = ball(2, {0.1 + 0.05 * speed_m_s, 0.05, 0.0}, 0.03, 0.2);
    shot.position_m.y() += 0.5 * kGravity * 0.05 * 0.05;
    shot.velocity_m_s = {-speed_m_s, 0, 0};
    EXPECT_TRUE(world.add_ball(shot));
    run_seconds(world, 0.2);
    return world.revision(kCup) > 0;
  };
  constexpr double kSpeed_m_s = 3.1;
  for (const double rate : kRates_hz) {
    for (const int substeps : {4, 8, 16, 32}) {
      SCOPED_TRACE(::testing::Message() << substeps << " substeps of " << rate << " Hz");
      EXPECT_FALSE(breaks(rate, substeps, 0.97 * kSpeed_m_s));
      EXPECT_TRUE(breaks(rate, substeps, 1.03 * kSpeed_m_s));
    }
  }
}

// The distance fields of the fragments overlap deeply at the start. The impulses that separate them must
// fade, so that the fragments press only with their weight. A contact with the floor counts once and one of
// two fragments twice, so a heap of two layers has three weights. Single heaps rock: the median of five.
TEST(BreakingLoads, FragmentHeapPressesWithItsWeight) {
  const auto pieces = pieces_of(small_cup(), 64, 1);
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    std::array<double, 5> weights;  // largest of a heap
    for (size_t heap = 0; heap < weights.size(); ++heap) {
      World world = with_cup(cup_at(4.0 + 0.001 * static_cast<double>(heap)), world_at(rate, 4), pieces);
      world.add_collider(floor_plane());
      run_seconds(world, 1.4);
      ASSERT_EQ(body_count(world, kCup), 64u);
      double worst = 0.0;
      for (int tick = 0; tick < 3 * rate; ++tick) {
        world.step();
        double sum = 0.0;
        for (const VoronoiPiece& piece : pieces->cut.pieces) {
          sum += world.contact_impulse_n_s(kCup, piece.mass.centre_of_mass_m);
        }
        worst = std::max(worst, sum);
      }
      weights[heap] = worst * rate / (kMass_kg * kGravity);
    }
    std::sort(weights.begin(), weights.end());
    RecordProperty("weights", std::to_string(weights[2]));
    EXPECT_LT(weights[2], 3.7);
    EXPECT_LT(weights.back(), 10.0);  // the heap that rocks most
  }
}

}  // namespace
}  // namespace livegs
