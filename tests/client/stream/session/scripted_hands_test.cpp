// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "scratch_folder.h"
#include "stream/session/scripted_hands.h"

namespace livegs {
namespace {

const ScriptedHands::Settings kSettings{{0, 1, 3}, 6.0};

std::optional<ObjectExtent> locate_hat(const std::string& name) {
  if (name != "hat") return std::nullopt;
  return ObjectExtent{{0, 0.5, 0}, 0.4};
}

Eigen::Vector3d ray(const HandSample& hand) { return hand.aim.orientation * -Eigen::Vector3d::UnitZ(); }

TEST(ScriptedHands, PokeAimsAtCentrePullsUpAndReleases) {
  ScriptedHands hands(poke_script("hat"), kSettings);
  EXPECT_EQ(hands.at(0.99, locate_hat).hands[1].trigger, 0.0f);
  const HandSample begun = hands.at(1.0, locate_hat).hands[1];
  EXPECT_EQ(begun.trigger, 1.0f);
  EXPECT_LT((begun.aim.position_m - kSettings.eye_m).norm(), 1e-12);
  EXPECT_LT((ray(begun) - Eigen::Vector3d(0, -0.5, -3).normalized()).norm(), 1e-9);
  const HandSample pulled = hands.at(1.6, locate_hat).hands[1];
  EXPECT_EQ(pulled.trigger, 1.0f);
  EXPECT_NEAR(pulled.aim.position_m.y() - kSettings.eye_m.y(), 0.8 * 0.4, 1e-9);
  EXPECT_LT((ray(pulled) - ray(begun)).norm(), 1e-12);  // the hand moves, the ray keeps its direction
  EXPECT_EQ(hands.at(2.01, locate_hat).hands[1].trigger, 0.0f);
}

TEST(ScriptedHands, GrabClosesAtCentreMovesAndOpens) {
  v1::InputScript script;
  v1::InputScript::Grab& grab = *script.add_actions()->mutable_grab();
  grab.set_object("hat");
  grab.set_start_s(0.5);
  grab.set_move_s(1.0);
  grab.set_hold_s(0.2);
  for (double along : {0.3, 0.2, 0.0}) grab.add_move_m(along);
  ScriptedHands hands(script, kSettings);
  EXPECT_EQ(hands.at(0.49, locate_hat).hands[0].squeeze, 0.0f);
  const HandSample closed = hands.at(0.5, locate_hat).hands[0];
  EXPECT_EQ(closed.squeeze, 1.0f);
  EXPECT_LT((closed.grip.position_m - Eigen::Vector3d(0, 0.5, 0)).norm(), 1e-12);
  EXPECT_LT((hands.at(1.0, locate_hat).hands[0].grip.position_m - Eigen::Vector3d(0.15, 0.6, 0)).norm(),
            1e-12);
  EXPECT_LT((hands.at(1.6, locate_hat).hands[0].grip.position_m - Eigen::Vector3d(0.3, 0.7, 0)).norm(),
            1e-12);
  EXPECT_FALSE(hands.done(1.6));
  EXPECT_EQ(hands.at(1.71, locate_hat).hands[0].squeeze, 0.0f);
  EXPECT_TRUE(hands.done(1.71));
}

TEST(ScriptedHands, SequencesIncreaseByOne) {
  ScriptedHands hands(poke_script("hat"), kSettings);
  for (uint64_t i = 1; i <= 5; ++i)
    EXPECT_EQ(hands.at(0.01 * static_cast<double>(i), locate_hat).sequence, i);
}

TEST(ScriptedHands, ThrownBallHitsItsTarget) {
  v1::InputScript script;
  script.add_actions()->mutable_ball()->set_object("hat");
  ScriptedHands hands(script, kSettings);
  const HandSample hand = hands.at(0, locate_hat).hands[0];
  ASSERT_TRUE(hand.shoot);
  // Free fall, g = 9.81: position after the horizontal distance is covered.
  const Eigen::Vector3d velocity = kSettings.ball_speed_m_s * ray(hand);
  const double time_s = -3.0 / velocity.z();
  EXPECT_NEAR(1.0 + velocity.y() * time_s - 0.5 * 9.81 * time_s * time_s, 0.5, 1e-9);
  EXPECT_FALSE(hands.at(0.01, locate_hat).hands[0].shoot);
  EXPECT_TRUE(hands.done(0.01));
}

TEST(ScriptedHands, SimultaneousBallsAreShotInTurn) {
  v1::InputScript script;
  for (int i = 0; i < 2; ++i) script.add_actions()->mutable_ball()->set_object("hat");
  ScriptedHands hands(script, kSettings);
  std::string shots;
  for (int i = 0; i < 5; ++i) shots += hands.at(0.01 * i, locate_hat).hands[0].shoot ? '1' : '0';
  EXPECT_EQ(shots, "10100");  // two rising edges
}

TEST(ScriptedHands, SkipsUnknownObjects) {
  ScriptedHands hands(poke_script("cup"), kSettings);
  EXPECT_EQ(hands.at(1.2, locate_hat).hands[1].trigger, 0.0f);
  EXPECT_FALSE(hands.at(4.0, locate_hat).hands[0].shoot);
}

TEST(ScriptFile, ReadsActions) {
  const ScratchFolder folder;
  const auto path = folder.write("script.json", R"({ "actions": [
    { "poke": { "object": "hat", "start_s": 0.5, "pull_m": [0, 0.1, 0], "hold_s": 2 } },
    { "ball": { "time_s": 3, "from_m": [1, 1, 1], "point": { "position_m": [0, 0, 0] } } } ] })");
  const auto script = read_script_file(path);
  ASSERT_TRUE(script) << script.error().message;
  EXPECT_EQ(script->actions_size(), 2);
  EXPECT_EQ(script->actions(0).poke().hold_s(), 2.0);
}

TEST(ScriptFile, ErrorsNameFileAndField) {
  const ScratchFolder folder;
  const struct {
    const char* text;
    const char* named;
  } cases[] = {
      {R"({ "actions": [ { "prod": {} } ] })", "prod"},
      {R"({ "actions": [ {} ] })", "actions[0]"},
      {R"({ "actions": [ { "poke": {} } ] })", "actions[0].poke.object"},
      {R"({ "actions": [ { "poke": { "object": "hat", "start_s": -1 } } ] })", "actions[0].poke.start_s"},
      {R"({ "actions": [ { "poke": { "object": "hat", "pull_m": [1, 2] } } ] })", "actions[0].poke.pull_m"},
      {R"({ "actions": [ { "ball": { "time_s": "NaN", "object": "hat" } } ] })", "actions[0].ball.time_s"},
      {R"({ "actions": [ { "ball": {} } ] })", "actions[0].ball"},
      {"{", ""},
  };
  for (const auto& one : cases) {
    const auto script = read_script_file(folder.write("bad.json", one.text));
    ASSERT_FALSE(script) << one.text;
    EXPECT_NE(script.error().message.find("bad.json"), std::string::npos) << script.error().message;
    EXPECT_NE(script.error().message.find(one.named), std::string::npos) << script.error().message;
  }
  EXPECT_FALSE(read_script_file(folder / "absent.json"));
}

}  // namespace
}  // namespace livegs
