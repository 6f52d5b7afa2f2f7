// SPDX-License-Identifier: Apache-2.0
#include "session/simulation/hand_controls.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "scenes/box_scene.h"

namespace livegs {
namespace {

using Eigen::Vector3d;

struct Hands {
  Scene scene = box_scene();
  HandControls controls;
  uint64_t sequence = 0;
  int looks = 1;  // samples per moment; the last is correct, the others lag by a millimetre each

  uint32_t id(const char* name) const { return scene.find(name)->id; }
  Vector3d middle(const char* name) const { return scene.world().world_point(id(name), Vector3d::Zero()); }
  HeldPoint held(size_t hand = 1) const { return controls.held_points(scene, 1)[hand]; }
  double rate_hz() const { return scene.world().settings().rate_hz; }

  // One tick with the right hand, or both, at a position.
  void tick(const Vector3d& right_m, float squeeze, const Vector3d* left_m = nullptr) {
    InputSample sample;
    for (size_t i = 0; i < 2; ++i) {
      if (i == 0 && !left_m) continue;
      sample.hands[i].active = true;
      sample.hands[i].grip.position_m = i == 0 ? *left_m : right_m;
      sample.hands[i].squeeze = squeeze;
    }
    apply(sample);
  }

  // One tick without client input.
  void silent_tick() {
    ++sequence;
    scene.step();
  }

  // One tick with the right hand's ray pointing straight down.
  void point_down(const Vector3d& from_m, float trigger) {
    InputSample sample;
    sample.hands[1].active = true;
    sample.hands[1].aim = {from_m, Eigen::Quaterniond(Eigen::AngleAxisd(-M_PI / 2, Vector3d::UnitX()))};
    sample.hands[1].trigger = trigger;
    apply(sample);
  }

 private:
  void apply(InputSample sample) {
    sample.sequence = ++sequence;
    sample.sampled_ns = std::llround(1e9 * static_cast<double>(sequence) / rate_hz());
    for (int look = looks; look-- > 0;) {
      InputSample seen = sample;
      for (HandSample& hand : seen.hands) hand.grip.position_m -= look * Vector3d(5e-4, 5e-4, 0);
      controls.apply(scene, 1, seen);
    }
    scene.step();
  }
};

TEST(HandControls, SqueezeGrabsAndCarriesTheNearestObject) {
  for (const char* name : {"box", "cube"}) {
    Hands hands;
    const Vector3d start = hands.middle(name);
    Vector3d hand = start + Vector3d(0, 0.11, 0);  // just above its top face
    hands.tick(hand, 1.0f);
    EXPECT_TRUE(hands.held().holding);
    EXPECT_TRUE(hands.held().grabbed);
    EXPECT_EQ(hands.held().object_id, hands.id(name));
    EXPECT_LT((hands.middle(name) - start).norm(), 1e-3) << name;  // it does not jump
    for (int i = 0; i < 90; ++i) hands.tick(hand += Vector3d(0, 0.3, 0) / 90.0, 1.0f);
    for (int i = 0; i < 60; ++i) hands.tick(hand, 1.0f);
    // Below the hand by the sag of the spring, g / (2 pi 8 Hz)² = 4 mm, and the deformation of a soft cube.
    EXPECT_NEAR(hands.middle(name).y() - start.y(), 0.3, std::string(name) == "box" ? 0.01 : 0.06);
    const double weight = hands.scene.find(hands.id(name))->mass_kg * 9.81;
    double mean_n = 0.0;  // a soft cube oscillates for a while
    for (int i = 0; i < 180; ++i) {
      hands.tick(hand, 1.0f);
      mean_n += hands.held().force_n.y() / 180.0;
    }
    EXPECT_NEAR(mean_n / weight, 1.0, 0.05) << name;
    EXPECT_EQ(hands.held().contact_impulse_n_s, 0.0);
    hands.tick(hand, 0.0f);
    EXPECT_FALSE(hands.held().holding);
  }
}

TEST(HandControls, OpenHandThrowsAndDistantHandGrabsNothing) {
  Hands hands;
  hands.tick(hands.middle("box") + Vector3d(0, 0.5, 0), 1.0f);
  EXPECT_FALSE(hands.held().holding);
  hands.tick(hands.middle("box"), 1.0f);  // closed before it arrived: no grab
  EXPECT_FALSE(hands.held().holding);
  hands.tick(hands.middle("box"), 0.0f);
  Vector3d hand = hands.middle("box");
  const Vector3d velocity(1.5, 1.5, 0);
  for (int i = 0; i < 36; ++i) hands.tick(hand += std::min(1.0, i / 18.0) * velocity / 90.0, 1.0f);
  EXPECT_TRUE(hands.held().holding);
  hands.tick(hand += velocity / 90.0, 0.0f);
  const Vector3d before = hands.middle("box");
  hands.tick(hand, 0.0f);
  EXPECT_LT(((hands.middle("box") - before) * 90.0 - velocity).norm(), 0.1 * velocity.norm());
}

// A client at 90 frames a second sends hands with every tick, one at 8 with every eleventh. Moved evenly and
// released, an object keeps the velocity of the hand. This also holds for a client that sends three samples
// per moment.
TEST(HandControls, ThrowsDoNotDependOnTheFrameRate) {
  const Vector3d velocity(1.5, 1.5, 0);
  for (const auto& [ticks_a_sample, looks] :
       {std::pair{1, 1}, {1, 3}, {3, 1}, {3, 3}, {6, 1}, {6, 3}, {11, 1}, {11, 3}}) {
    Hands hands;
    hands.looks = looks;
    Vector3d hand = hands.middle("box");
    hands.tick(hand, 0.0f);
    double slowest = INFINITY, fastest = 0;
    Vector3d before = hand;
    const int samples = 90 / ticks_a_sample;
    for (int i = 0; i < samples; ++i) {
      const double share = std::min(1.0, 2.5 * i / samples);
      hands.tick(hand += share * ticks_a_sample * velocity / 90.0, 1.0f);
      for (int rest = 0; rest < ticks_a_sample; ++rest) {
        if (rest > 0) hands.silent_tick();
        const double speed = 90.0 * (hands.middle("box") - before).norm() / velocity.norm();
        before = hands.middle("box");
        if (i < 0.7 * samples) continue;
        slowest = std::min(slowest, speed);
        fastest = std::max(fastest, speed);
      }
    }
    hands.tick(hand += ticks_a_sample * velocity / 90.0, 0.0f);
    before = hands.middle("box");
    hands.silent_tick();
    const double thrown = ((hands.middle("box") - before) * 90.0 - velocity).norm() / velocity.norm();
    std::printf(
        "%2d ticks a sample, %d looks: carried at %.3f to %.3f of the hand's speed, thrown %.3f off\n",
        ticks_a_sample, looks, slowest, fastest, thrown);
    EXPECT_GT(slowest, 0.85) << ticks_a_sample;
    EXPECT_LT(fastest, 1.15) << ticks_a_sample;
    EXPECT_LT(thrown, 0.1) << ticks_a_sample;
  }
}

// A hand without samples stops at its extrapolated position.
TEST(HandControls, HandWithoutSamplesStops) {
  Hands hands;
  Vector3d hand = hands.middle("box");
  hands.tick(hand, 0.0f);
  hands.tick(hand, 1.0f);
  for (int i = 0; i < 30; ++i) {
    hands.tick(hand += Vector3d(0, 0.06, 0), 1.0f);
    for (int rest = 1; rest < 6; ++rest) hands.silent_tick();
  }
  for (int i = 0; i < 180; ++i) hands.silent_tick();
  EXPECT_NEAR(hands.middle("box").y(), hand.y() + 0.06, 0.01);
}

TEST(HandControls, TwoHandsHoldOneObjectAndFeelContacts) {
  Hands hands;
  const Vector3d middle = hands.middle("box");
  Vector3d left = middle + Vector3d(-0.1, 0, 0), right = middle + Vector3d(0.1, 0, 0);
  const auto move = [&](double up_m, int ticks) {
    for (int i = 0; i < ticks; ++i) {
      left.y() += up_m / ticks;
      right.y() += up_m / ticks;
      hands.tick(right, 1.0f, &left);
    }
  };
  move(0.0, 1);
  move(0.2, 45);
  move(0.0, 45);
  EXPECT_NEAR(hands.held(0).force_n.y() + hands.held(1).force_n.y(), 9.81, 0.1);  // 1 kg
  // Hit against the floor: each hand receives the impulse on the box.
  double largest = 0.0;
  for (int i = 0; i < 30; ++i) {
    move(-0.02, 1);
    EXPECT_EQ(hands.held(0).contact_impulse_n_s, hands.held(1).contact_impulse_n_s);
    EXPECT_EQ(hands.held(1).contact_impulse_n_s,
              hands.scene.world().contact_impulse_n_s(hands.id("box"), Eigen::Vector3d::Zero()));
    largest = std::max(largest, hands.held(1).contact_impulse_n_s);
  }
  EXPECT_GT(largest, 0.5);  // 1 kg that fell at up to 1.8 m/s
  EXPECT_LT(largest, 5.0);
}

TEST(HandControls, GripForceIsBounded) {
  Hands hands;
  hands.tick(hands.middle("box"), 1.0f);
  ASSERT_TRUE(hands.held().grabbed);
  const World::Grip grip = hand_grip(1.0);
  for (int i = 0; i < 50; ++i) {
    hands.tick(Vector3d(i % 2 ? 999.0 : -999.0, 500.0, 0), 1.0f);
    ASSERT_LE(hands.held().force_n.norm(), grip.max_force_n * 1.000001);
    ASSERT_LE(hands.held().torque_n_m.norm(), grip.max_torque_n_m * 1.000001);
  }
  // At most force times time over mass: 196 N and gravity on 1 kg for 50 ticks.
  EXPECT_LT((hands.middle("box")).norm(), 0.5 * 206.0 * std::pow(51.0 / 90.0, 2) + 1.0);
  hands.controls.release(hands.scene, 1);
  EXPECT_FALSE(hands.held().holding);
}

// A grab or a ray on an object that fractures continues with the fragment at its point and carries that
// fragment alone. So does a grab of a fragment.
TEST(HandControls, HoldsOneFragmentAfterFracture) {
  for (const bool whole : {true, false}) {
    for (const bool ray : {false, true}) {
      SCOPED_TRACE(std::string(whole ? "taken whole" : "taken from the heap") +
                   (ray ? " by a ray" : " by a hand"));
      Hands hands{.scene = breaking_scene(), .controls = {}};  // fractures after 90 ticks
      Vector3d hand = hands.middle("box") + Vector3d(0.03, ray ? 0.6 : 0.1, 0.03);
      const auto run = [&](double up_m, int ticks, float closed) {
        for (int i = 0; i < ticks; ++i) {
          hand.y() += up_m / ticks;
          ray ? hands.point_down(hand, closed) : hands.tick(hand, closed);
        }
      };
      if (!whole) run(0.0, 200, 0.0f);
      run(0.0, 1, 1.0f);
      ASSERT_TRUE(hands.held().holding);
      run(0.4, 60, 1.0f);
      run(0.0, 200, 1.0f);
      double mean_n = 0.0, held_kg = 0.0;
      for (int i = 0; i < 90; ++i) {
        run(0.0, 1, 1.0f);
        mean_n += hands.held().force_n.y() / 90.0;
      }
      int pieces = 0, up = 0;
      for (const BodyState& body : hands.scene.world().bodies()) {
        ++pieces;
        if (body.world_from_body.position_m.y() < 0.3) continue;
        ++up;
        held_kg = body.mass_kg;
      }
      EXPECT_GT(pieces, 4);
      EXPECT_EQ(up, 1);
      EXPECT_LT(held_kg, 0.6);
      EXPECT_NEAR(mean_n, 9.81 * held_kg, 0.02 * 9.81 * held_kg);
      run(0.0, 1, 0.0f);
      EXPECT_FALSE(hands.held().holding);
    }
  }
}

// Each hand has its own spring, so an object that two clients hold moves to the middle, and to one of them
// when the other releases it or disconnects.
TEST(HandControls, TwoClientsHoldOneObjectBetweenThem) {
  for (const bool vanishes : {false, true}) {
    Hands hands;
    const Vector3d start = hands.middle("box");
    std::array<Vector3d, 2> hand = {start - Vector3d(0.1, 0, 0), start + Vector3d(0.1, 0, 0)};
    std::array<float, 2> squeeze = {1.0f, 1.0f};
    uint64_t sequence = 0;
    bool second_is_here = true;
    const auto tick = [&] {
      ++sequence;
      for (const SessionNumber session : {1u, 2u}) {
        if (session == 2 && !second_is_here) continue;
        InputSample sample;
        sample.sequence = sequence;
        sample.sampled_ns = std::llround(1e9 * static_cast<double>(sequence) / hands.rate_hz());
        sample.hands[1].active = true;
        sample.hands[1].grip.position_m = hand[session - 1];
        sample.hands[1].squeeze = squeeze[session - 1];
        hands.controls.apply(hands.scene, session, sample);
      }
      hands.scene.step();
    };
    const auto move = [&](const Vector3d& first, const Vector3d& second, int ticks) {
      for (int i = 0; i < ticks; ++i) {
        hand[0] += first / ticks;
        hand[1] += second / ticks;
        tick();
      }
    };
    tick();
    ASSERT_TRUE(hands.controls.holding(1));
    ASSERT_TRUE(hands.controls.holding(2));
    const Vector3d up(0, 0.2, 0), apart(0.1, 0, 0);
    move(up, up, 45);
    move(-apart, apart, 45);
    move(Vector3d::Zero(), Vector3d::Zero(), 60);
    EXPECT_LT((hands.middle("box") - start - up).norm(), 0.01);
    const auto force_n = [&](SessionNumber session) {
      return hands.controls.held_points(hands.scene, session)[1].force_n;
    };
    EXPECT_NEAR(force_n(1).y() + force_n(2).y(), 9.81, 0.1);  // 1 kg shared
    EXPECT_NEAR(force_n(1).x(), -force_n(2).x(), 0.1);
    EXPECT_GT(std::abs(force_n(1).x()), 1.0);
    if (vanishes) {
      hands.controls.on_session_closed(hands.scene, 2);
      second_is_here = false;
    } else {
      squeeze[1] = 0.0f;
    }
    move(Vector3d::Zero(), Vector3d::Zero(), 90);
    EXPECT_FALSE(hands.controls.holding(2));
    EXPECT_TRUE(hands.controls.holding(1));
    EXPECT_LT((hands.middle("box") - start - up + apart).norm(), 0.02);  // as held by the first
  }
}

}  // namespace
}  // namespace livegs
