// SPDX-License-Identifier: Apache-2.0
// The analysis of a scene that runs, with a model that the test makes up.
#include "session/live_analysis.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <nlohmann/json.hpp>

#include "analysis/physics_file.h"
#include "core/log.h"
#include "scratch_folder.h"
#include "server/analysis/fake_endpoint.h"
#include "server/session/raw_client.h"
#include "server/session/tick_log.h"
#include "session/live_run.h"
#include "session/live_server.h"

namespace livegs {
namespace {

using v1::EstimatedValue;

// A block and a sponge whose physics are left open, but for what is told of the block, and a box whose are told.
Scene open_scene(const ScratchFolder& folder, const std::string& block_physics = "{}", const std::string& block_m = "0.1",
                 uint32_t first_object_id = 1) {
  std::string points = "x,y,z\n";
  for (int i = 0; i < 64; ++i) {
    points += std::to_string(0.02 * (i % 4)) + "," + std::to_string(0.02 * (i / 4 % 4)) + "," +
              std::to_string(0.02 * (i / 16)) + "\n";
  }
  folder.write("sponge.csv", points);
  std::string text = R"({
    "substeps": 4, "environment": { "colliders": [ { "plane": {} } ] },
    "objects": [
      { "name": "wood block", "shape": { "box": { "size_m": [SIZE, 0.1, 0.1] } }, "pose": { "position_m": [0, 0.05, 0] },
        "physics": PHYSICS },
      { "name": "told", "shape": { "box": { "size_m": [0.1, 0.1, 0.1] } }, "pose": { "position_m": [1, 0.05, 0] },
        "physics": { "behavior": "RIGID", "mass_kg": 1.0 } },
      { "name": "sponge", "points": "sponge.csv", "pose": { "position_m": [-1, 0.01, 0] } } ] })";
  text.replace(text.find("SIZE"), 4, block_m);
  text.replace(text.find("PHYSICS"), 7, block_physics);
  const auto path = folder.write("open.scene.json", text);
  SceneOptions options;
  options.rate_hz = 90;
  options.first_object_id = first_object_id;
  auto scene = Scene::load(path, options);
  EXPECT_TRUE(scene) << scene.error().message;
  return std::move(*scene);
}

// 450 g for the block, 20 g for the sponge.
Result<std::string> weigh(const AnalysisQuestion& question, const ToolBox&, int) {
  const bool block = question.slots.at("name") == "wood block";
  const double grams = block ? 450 : 20;
  return nlohmann::json{
      {"name", block ? "block" : "sponge"},
      {"evidence", "grain"},
      {"fill", "solid"},
      {"parts", {{{"name", "all"}, {"material_id", block ? "softwood" : "kitchen sponge"}, {"share", 1}}}},
      {"behaviour", block ? "rigid" : "elastic"},
      {"mass_g", {{"low", grams * 0.9}, {"best", grams}, {"high", grams * 1.1}}},
      {"young_mpa", nullptr},
      {"structure_s", nullptr},
      {"plasticity", nullptr},
      {"fragile", false},
      {"friction", 0.4},
      {"restitution", 0.3},
      {"confidence", 0.9}}
      .dump();
}

// The block ten times as heavy as it can be thought to be.
Result<std::string> weigh_too_much(const AnalysisQuestion& question, const ToolBox& tools, int turn) {
  auto answer = nlohmann::json::parse(*weigh(question, tools, turn));
  if (question.slots.at("name") == "wood block") answer["mass_g"] = {{"low", 4500}, {"best", 5000}, {"high", 5500}};
  return answer.dump();
}

class LiveAnalysisTest : public ::testing::Test {
 protected:
  // `say` null: no endpoint.
  void start(FakeEndpoint::Say say, std::chrono::milliseconds delay = std::chrono::milliseconds(0)) {
    skipped = log.ticks().size();
    Scene scene = open_scene(folder, block_physics);
    for (const SceneObject& object : scene.objects()) {
      ids[object.name] = object.id;
      offline_kg[object.name] = object.physics.mass_kg().best();
    }
    auto analysed = SceneAnalysis::of(scene);
    ASSERT_TRUE(analysed) << analysed.error().message;
    loop = std::make_unique<SimulationLoop>(std::move(scene), log, [this](const Scene& now) {
      for (const BodyState& body : now.world().bodies()) {
        if (body.object_id != ids.at("wood block")) continue;
        if (!body.asleep && block_asleep) ++awakenings;
        block_asleep = body.asleep;
      }
    });
    std::unique_ptr<FakeEndpoint> made;
    if (say) made = std::make_unique<FakeEndpoint>(std::move(say));
    if (made) made->delay = [delay](const std::string&) { return delay; };
    endpoint = made.get();
    analysis = std::make_unique<LiveAnalysis>(std::move(*analysed), std::move(made), *loop);
    loop->start();
  }
  // Waits for a tick in which the object changed to what `enough` accepts.
  bool changes_to(const std::string& name, const std::function<bool(const SceneObject&)>& enough) {
    return log.wait([&](const std::vector<SteppedTick>& ticks) {
      for (size_t i = skipped; i < ticks.size(); ++i) {
        for (const SceneObject& object : ticks[i].changed) {
          if (object.id == ids.at(name) && enough(object)) return true;
        }
      }
      return false;
    });
  }
  // One object, asked about as a client does; what it was told last.
  v1::AnalysisProgress analyzed(const std::string& name) {
    std::mutex mutex;
    std::condition_variable changed;
    bool ended = false;
    v1::AnalysisProgress last;
    EXPECT_TRUE(analysis->analyze(
        {name},
        [&](const v1::AnalysisProgress& progress) {
          last = progress;
          return true;
        },
        [&] {
          std::lock_guard lock(mutex);
          ended = true;
          changed.notify_all();
        }));
    std::unique_lock lock(mutex);
    EXPECT_TRUE(changed.wait_for(lock, kPatience, [&] { return ended; }));
    return last;
  }
  size_t changes_of(const std::string& name) {
    size_t count = 0;
    for (const SteppedTick& tick : log.ticks()) {
      for (const SceneObject& object : tick.changed) count += object.id == ids.at(name) ? 1 : 0;
    }
    return count;
  }

  ScratchFolder folder;
  TickLog log;
  std::string block_physics = "{}";
  std::atomic<bool> block_asleep = false;
  std::atomic<int> awakenings = 0;
  size_t skipped = 0;  // ticks of those that were started before
  std::map<std::string, uint32_t> ids;
  std::map<std::string, double> offline_kg;
  std::unique_ptr<SimulationLoop> loop;
  FakeEndpoint* endpoint = nullptr;
  std::unique_ptr<LiveAnalysis> analysis;
};

bool by_model(const SceneObject& object) {
  return object.physics.mass_kg().source() == EstimatedValue::MODEL;
}

TEST_F(LiveAnalysisTest, WhatIsAcceptedLandsAtATickAsOneChange) {
  start(weigh);
  analysis->begin();
  ASSERT_TRUE(changes_to("wood block", by_model));
  ASSERT_TRUE(changes_to("sponge", by_model));
  EXPECT_EQ(changes_of("wood block"), 1u);
  EXPECT_EQ(changes_of("told"), 0u);  // its behaviour is told: nobody was asked
  for (const std::string& line : endpoint->asked()) {
    EXPECT_EQ(line.find("told <"), std::string::npos) << line;
    EXPECT_NE(line.find(" told!1.000000"), std::string::npos) << line;  // the others are told of it
  }
  loop->stop();
  const SceneObject* block = loop->scene().find("wood block");
  EXPECT_EQ(block->mass_kg, block->physics.mass_kg().best());
  EXPECT_EQ(loop->scene().world().material(block->id)->mass_kg, block->mass_kg);
  // Between the model's 450 g and the estimate.
  EXPECT_GE(block->mass_kg, std::min(0.45, offline_kg["wood block"]) - 1e-9);
  EXPECT_LE(block->mass_kg, std::max(0.45, offline_kg["wood block"]) + 1e-9);
  // And stays beside its asset or the scene: the next start asks nothing.
  for (const char* name : {"sponge.physics.json", "open.scene.physics.wood%20block.json"}) {
    const auto kept = read_physics_file(folder / name);
    ASSERT_TRUE(kept);
    EXPECT_EQ(kept->analysis().model(), "fake-1") << name;
  }
  EXPECT_TRUE(by_model(*open_scene(folder).find("sponge")));
  EXPECT_TRUE(by_model(*open_scene(folder).find("wood block")));
}

// The next start takes it that whoever undid an answer does not want it back; another question is another matter.
TEST_F(LiveAnalysisTest, AnAnswerThatWasTakenBackDoesNotComeBackByItself) {
  start(weigh);
  analysis->begin();
  ASSERT_TRUE(changes_to("wood block", by_model));
  ASSERT_TRUE(changes_to("sponge", by_model));
  ASSERT_TRUE(analysis->undo_physics("wood block", false));
  v1::Physics edit;
  edit.set_friction(0.5);
  ASSERT_TRUE(analysis->set_physics("wood block", edit));  // what comes after it makes no difference
  analysis.reset();
  loop->stop();

  start(weigh);
  set_log_level(LogLevel::Info);
  testing::internal::CaptureStderr();
  analysis->begin();
  const std::string told = testing::internal::GetCapturedStderr();
  EXPECT_NE(told.find("wood block: its answer was taken back or declined"), std::string::npos) << told;
  EXPECT_EQ(told.find("is asked about"), std::string::npos) << told;
  EXPECT_EQ(analyzed("wood block").verdict(), v1::AnalysisProgress::ACCEPTED);  // a person asks
  EXPECT_EQ(endpoint->asked().size(), 1u);
  analysis.reset();
  loop->stop();

  // An edit that is undone is no answer, and who deletes the sidecar forgets all.
  ASSERT_TRUE(undo_physics(folder / "open.scene.physics.wood%20block.json"));
  std::filesystem::remove(folder / "open.scene.physics.wood%20block.json");
  v1::Physics heavy;
  heavy.set_mass_kg(0.7);
  std::filesystem::remove(folder / "sponge.physics.json");
  std::filesystem::remove(folder / "sponge.physics.log");
  ASSERT_TRUE(edit_physics(folder / "sponge.physics.json", heavy));
  ASSERT_TRUE(undo_physics(folder / "sponge.physics.json"));
  start(weigh);
  analysis->begin();
  ASSERT_TRUE(changes_to("wood block", by_model));
  ASSERT_TRUE(changes_to("sponge", by_model));
}

// What the server's own start found and does not take upon itself reaches the log, and changes nothing of the scene.
TEST_F(LiveAnalysisTest, AProposalOfTheStartIsToldAndWaits) {
  const auto touched = [&] {
    for (const SteppedTick& tick : log.ticks()) {
      for (const SceneObject& one : tick.changed) {
        if (one.name == "wood block") return true;
      }
    }
    return false;
  };
  set_log_level(LogLevel::Info);
  testing::internal::CaptureStderr();
  start(weigh_too_much);
  analysis->begin();
  EXPECT_TRUE(changes_to("sponge", by_model));
  EXPECT_EQ(analyzed("sponge").verdict(), v1::AnalysisProgress::ACCEPTED);  // the start's lines are written by then
  analysis.reset();
  loop->stop();
  EXPECT_FALSE(touched());
  std::string told = testing::internal::GetCapturedStderr();
  EXPECT_NE(told.find("analysis: wood block: needs review: mass_g.best: 5000 g is more than 8 times away"), std::string::npos)
      << told;
  EXPECT_NE(told.find("kept as a proposal: Accept in the window or livegs analyze --accept takes it; Decline, --decline or an edit"), std::string::npos);
  EXPECT_NE(told.find("analysis: sponge: accepted"), std::string::npos) << told;

  // The next start asks nobody about it and says that it is there.
  testing::internal::CaptureStderr();
  start(weigh_too_much);
  analysis->begin();
  told = testing::internal::GetCapturedStderr();
  EXPECT_NE(told.find("wood block: a proposal waits from before"), std::string::npos) << told;
  EXPECT_TRUE(endpoint->asked().empty());
  std::vector<std::string> offered;
  analysis->watch_proposals([&](const std::string& object, const v1::PhysicalParameters* proposal) {
    offered.push_back(object + (proposal ? " waits" : " waits no longer"));
  });
  ASSERT_TRUE(analysis->accept_proposal("wood block"));
  analysis->watch_proposals({});
  EXPECT_EQ(offered, (std::vector<std::string>{"wood block waits", "wood block waits no longer"}));
  EXPECT_TRUE(changes_to("wood block", [](const SceneObject& one) { return one.mass_kg > 2; }));
}

// A thing that sleeps and slides without friction does so while an answer waits for a person.
TEST_F(LiveAnalysisTest, AProposalThatWaitsLeavesTheSceneUntouched) {
  block_physics = R"({ "friction": 0 })";
  start(weigh_too_much);
  ASSERT_TRUE(log.wait([&](const auto&) { return block_asleep.load(); }));
  ASSERT_EQ(analyzed("wood block").verdict(), v1::AnalysisProgress::NEEDS_REVIEW);
  const size_t then = log.ticks().size();
  ASSERT_TRUE(log.wait([&](const auto& ticks) { return ticks.size() > then + 20; }));
  EXPECT_EQ(changes_of("wood block"), 0u);
  ASSERT_TRUE(analysis->decline_proposal("wood block"));
  const size_t declined = log.ticks().size();
  ASSERT_TRUE(log.wait([&](const auto& ticks) { return ticks.size() > declined + 20; }));
  EXPECT_EQ(changes_of("wood block"), 0u);
  EXPECT_EQ(awakenings, 0);
  loop->stop();
  const SceneObject* block = loop->scene().find("wood block");
  EXPECT_EQ(loop->scene().world().material(block->id)->friction, 0);
  EXPECT_EQ(block->mass_kg, offline_kg["wood block"]);
}

// It ends for good: neither this server nor the next one asks again by itself.
TEST_F(LiveAnalysisTest, WhatWasDeclinedOrEditedWaitsNoLonger) {
  for (const bool by_edit : {false, true}) {
    start(weigh_too_much);
    ASSERT_EQ(analyzed("wood block").verdict(), v1::AnalysisProgress::NEEDS_REVIEW);
    if (by_edit) {
      v1::Physics edit;
      edit.set_mass_kg(0.5);
      ASSERT_TRUE(analysis->set_physics("wood block", edit));
    } else {
      const auto declined = analysis->decline_proposal("wood block");
      ASSERT_TRUE(declined) << declined.error().message;
      EXPECT_EQ(declined->parameters().mass_kg().best(), offline_kg["wood block"]);
    }
    EXPECT_EQ(analysis->accept_proposal("wood block").error().code, ErrorCode::NotFound);
    EXPECT_EQ(analysis->decline_proposal("wood block").error().code, ErrorCode::NotFound);
    analysis.reset();
    loop->stop();

    start(weigh_too_much);
    bool offered = false;
    analysis->watch_proposals([&](const std::string&, const v1::PhysicalParameters*) { offered = true; });
    EXPECT_FALSE(offered);
    analysis->begin();
    ASSERT_TRUE(changes_to("sponge", by_model));
    for (const std::string& line : endpoint->asked()) EXPECT_FALSE(line.starts_with("wood block")) << line;
    analysis.reset();
    loop->stop();
    for (const char* name : {"open.scene.physics.wood%20block", "sponge.physics"}) {
      for (const char* ending : {".json", ".log"}) std::filesystem::remove(folder / (std::string(name) + ending));
    }
  }
}

// What was decided while the scene was loaded anew holds from its first tick, and what its file says by then counts.
TEST_F(LiveAnalysisTest, AResetKeepsWhatWasDecidedMeanwhileAndHearsTheFile) {
  start(nullptr);
  v1::Physics edit;
  edit.set_mass_kg(0.7);
  LiveRun run(
      *loop,
      [&](uint32_t first_id) -> Result<Scene> {
        Scene anew = open_scene(folder, R"({ "friction": 0.9 })", "0.2", first_id);
        EXPECT_TRUE(analysis->set_physics("wood block", edit));
        return anew;
      },
      [&](Scene anew) { analysis->replace(std::move(anew)); });
  v1::ControlRunRequest reset;
  reset.set_reset(true);
  ASSERT_TRUE(run.control(reset));
  ASSERT_TRUE(log.wait([](const auto& ticks) { return !ticks.empty() && ticks.back().run.resets == 1; }));
  for (const SteppedTick& tick : log.ticks()) {
    if (!tick.scene_is_new) continue;
    const auto block = std::find_if(tick.added.begin(), tick.added.end(), [](const auto& one) { return one.name == "wood block"; });
    ASSERT_NE(block, tick.added.end());
    EXPECT_EQ(block->mass_kg, 0.7);
    EXPECT_EQ(block->physics.friction().best(), 0.9);
  }
  edit.set_friction(0.3);
  const auto reply = analysis->set_physics("wood block", edit);
  ASSERT_TRUE(reply) << reply.error().message;
  EXPECT_EQ(reply->parameters().friction().best(), 0.9);
  EXPECT_EQ(reply->parameters().friction().source(), EstimatedValue::SCENE);
  EXPECT_NEAR(reply->parameters().longest_side_m().best(), 0.2, 1e-9);
  ASSERT_EQ(reply->warnings_size(), 1);
  EXPECT_TRUE(reply->warnings(0).starts_with("the edit of friction has no effect")) << reply->warnings(0);
}

TEST_F(LiveAnalysisTest, AnEditIsLockedAndCanBeUndoneAndRedone) {
  start(weigh);
  for (const char* name : {"wood block", "sponge"}) {
    v1::Physics edit;
    edit.set_mass_kg(0.7);
    const auto edited = analysis->set_physics(name, edit);
    ASSERT_TRUE(edited) << edited.error().message;
    EXPECT_EQ(edited->parameters().mass_kg().source(), EstimatedValue::PERSON);
    ASSERT_TRUE(changes_to(name, [](const SceneObject& one) { return one.physics.mass_kg().best() == 0.7; }));

    const v1::AnalysisProgress last = analyzed(name);
    EXPECT_EQ(last.verdict(), v1::AnalysisProgress::ACCEPTED) << last.message();
    EXPECT_EQ(last.parameters().mass_kg().best(), 0.7);  // locked
    EXPECT_EQ(last.parameters().friction().source(), EstimatedValue::MODEL);

    ASSERT_TRUE(analysis->undo_physics(name, false));  // the analysis
    const auto undone = analysis->undo_physics(name, false);
    ASSERT_TRUE(undone);
    EXPECT_EQ(undone->parameters().mass_kg().source(), EstimatedValue::OFFLINE);
    const auto redone = analysis->undo_physics(name, true);
    ASSERT_TRUE(redone);
    EXPECT_EQ(redone->parameters().mass_kg().best(), 0.7);
    ASSERT_TRUE(analysis->undo_physics(name, false));
    EXPECT_EQ(analysis->undo_physics(name, false).error().code, ErrorCode::NotFound);
  }
}

// A shape of a scene that has no file.
TEST(DecidedPhysics, WhatHasNoFileIsToldOnceToHoldUntilTheEnd) {
  DecidedPhysics decided("");
  std::string note;
  v1::Physics edit;
  edit.set_mass_kg(0.7);
  ASSERT_TRUE(decided.edit(edit, "", note));
  EXPECT_EQ(note, "there is no file to keep it in: it holds until the server ends; write it into the scene file");
  note.clear();
  edit.set_mass_kg(0.8);
  ASSERT_TRUE(decided.edit(edit, "", note));
  EXPECT_EQ(note, "");
  ASSERT_TRUE(decided.step(false, note));
  EXPECT_EQ(decided.present()->edits().mass_kg(), 0.7);
  ASSERT_TRUE(decided.step(false, note));
  EXPECT_FALSE(decided.step(false, note));
  ASSERT_TRUE(decided.step(true, note));
  EXPECT_EQ(decided.present()->edits().mass_kg(), 0.7);
}

// What a person said since the scene was loaded is what the next answer is asked for and weighed against with.
TEST_F(LiveAnalysisTest, AnEditCountsInTheNextAnalysis) {
  std::mutex mutex;
  std::string told;
  start([&](const AnalysisQuestion& question, const ToolBox& tools, int turn) -> Result<std::string> {
    std::lock_guard lock(mutex);
    const auto slot = question.slots.find("told");
    told = slot == question.slots.end() ? "" : slot->second;
    auto answer = nlohmann::json::parse(*weigh(question, tools, turn));
    answer["mass_g"] = {{"low", 4500}, {"best", 5000}, {"high", 5500}};
    return answer.dump();
  });
  const auto analyzed = [&] {
    std::condition_variable changed;
    bool ended = false;
    v1::AnalysisProgress last;
    EXPECT_TRUE(analysis->analyze(
        {"wood block"},
        [&](const v1::AnalysisProgress& progress) {
          last = progress;
          return true;
        },
        [&] {
          std::lock_guard lock(mutex);
          ended = true;
          changed.notify_all();
        }));
    std::unique_lock lock(mutex);
    EXPECT_TRUE(changed.wait_for(lock, kPatience, [&] { return ended; }));
    return last;
  };
  EXPECT_FALSE(analysis->accept_proposal("wood block"));
  EXPECT_EQ(analyzed().verdict(), v1::AnalysisProgress::NEEDS_REVIEW);  // ten times the estimate
  EXPECT_EQ(told, "");
  // A person may take it all the same, and back.
  const auto accepted = analysis->accept_proposal("wood block");
  ASSERT_TRUE(accepted) << accepted.error().message;
  EXPECT_EQ(accepted->parameters().mass_kg().source(), EstimatedValue::MODEL);
  EXPECT_GT(accepted->parameters().mass_kg().best(), 2);  // of the answer, 5 kg, and the estimate, a tenth of it, as the gate fuses them
  ASSERT_TRUE(changes_to("wood block", [](const SceneObject& one) { return one.mass_kg > 2; }));
  ASSERT_TRUE(analysis->undo_physics("wood block", false));
  v1::Physics edit;
  edit.set_mass_kg(5);
  ASSERT_TRUE(analysis->set_physics("wood block", edit));
  const auto last = analyzed();
  EXPECT_EQ(last.verdict(), v1::AnalysisProgress::ACCEPTED) << last.message();
  EXPECT_EQ(last.parameters().mass_kg().source(), EstimatedValue::PERSON);
  EXPECT_EQ(last.parameters().friction().source(), EstimatedValue::MODEL);
  EXPECT_EQ(told, "mass_kg 5");
}

// What a person calls it counts as its name from then on, also in the next question.
TEST_F(LiveAnalysisTest, ANameChangesWhatItIsTakenFor) {
  start(nullptr);
  const auto renamed = analysis->set_physics("sponge", {}, "steel bolt");
  ASSERT_TRUE(renamed) << renamed.error().message;
  EXPECT_EQ(renamed->parameters().material(), "carbon steel");
  ASSERT_TRUE(changes_to("sponge", [](const SceneObject& one) { return one.physics.material() == "carbon steel"; }));
  EXPECT_EQ(read_physics_file(folder / "sponge.physics.json")->name(), "steel bolt");
  const auto undone = analysis->undo_physics("sponge", false);
  ASSERT_TRUE(undone);
  EXPECT_NE(undone->parameters().material(), "carbon steel");
}

TEST_F(LiveAnalysisTest, BadEditsNameTheField) {
  start(nullptr);
  v1::Physics edit;
  edit.set_friction(-1);
  EXPECT_EQ(analysis->set_physics("wood block", edit).error().message,
            "physics.friction: is -1; it must be between 0 and 2");
  edit.set_friction(0.5);
  EXPECT_NE(analysis->set_physics("hat", edit).error().message.find("it has: wood block, told, sponge"),
            std::string::npos);
}

TEST_F(LiveAnalysisTest, AnEditOfWhatTheSceneWritesIsAnsweredSo) {
  start(nullptr);
  v1::Physics edit;
  edit.set_mass_kg(3.0);
  const auto reply = analysis->set_physics("told", edit);
  ASSERT_TRUE(reply) << reply.error().message;
  ASSERT_EQ(reply->warnings_size(), 1);
  EXPECT_EQ(reply->warnings(0),
            "the edit of mass_kg has no effect, because the scene file writes it; take it out of there to edit it here");
}

TEST(BuiltAs, WhatNeedsAnotherBodyWaitsForTheNextLoad) {
  v1::PhysicalParameters physics;
  physics.set_behavior(v1::Physics::RIGID);
  physics.set_fragile(true);
  EXPECT_TRUE(hold_as_built({v1::Physics::RIGID, true}, physics).empty());
  const auto uncut = hold_as_built({v1::Physics::RIGID, false}, physics);
  ASSERT_EQ(uncut.size(), 1u);
  EXPECT_EQ(uncut[0], "fragile: it cannot break until the scene is loaded anew");
  EXPECT_EQ(hold_as_built({v1::Physics::ELASTIC, false}, physics).size(), 2u);
  EXPECT_EQ(physics.behavior(), v1::Physics::ELASTIC);
}

TEST_F(LiveAnalysisTest, WhatCannotChangeWhileItRunsIsTold) {
  start(nullptr);
  v1::Physics edit;
  edit.set_behavior(v1::Physics::ELASTIC);
  edit.set_friction(0.77);
  const auto reply = analysis->set_physics("wood block", edit);
  ASSERT_TRUE(reply) << reply.error().message;
  ASSERT_EQ(reply->warnings_size(), 1);
  EXPECT_EQ(reply->warnings(0),
            "behavior: it stays RIGID until the scene is loaded anew, then it is ELASTIC");
  EXPECT_EQ(reply->parameters().behavior(), v1::Physics::RIGID);
  ASSERT_TRUE(changes_to("wood block", [](const SceneObject& one) {
    return one.physics.friction().best() == 0.77 && one.physics.behavior() == v1::Physics::RIGID &&
           one.physics.behavior_reason().find("loaded anew") != std::string::npos;
  }));
}

TEST_F(LiveAnalysisTest, AHangDelaysNeitherTheTicksNorTheEnd) {
  start(weigh, std::chrono::minutes(10));
  analysis->begin();
  ASSERT_TRUE(log.wait([&](const auto& ticks) { return ticks.size() > 20; }));
  analysis.reset();  // within milliseconds: else this test runs into its time limit
  EXPECT_EQ(changes_of("wood block"), 0u);
}

// Over gRPC, as clients see it.
TEST_F(LiveAnalysisTest, ClientsFollowAnalysesAndEdit) {
  auto listening = LiveServer::listen("127.0.0.1:0");
  ASSERT_TRUE(listening);
  auto server = std::move(*listening);
  start(weigh);
  loop->stop();
  server->open(loop->scene(), *loop);
  RawClient client(server->port());
  const auto set = [&](const char* object, double mass_kg, v1::PhysicsReply& reply) {
    grpc::ClientContext context;
    set_patience(context);
    v1::SetPhysicsRequest request;
    request.set_object(object);
    request.mutable_physics()->set_mass_kg(mass_kg);
    return client.stub().SetPhysics(&context, request, &reply);
  };
  v1::PhysicsReply reply;
  EXPECT_EQ(set("wood block", 1, reply).error_code(), grpc::StatusCode::UNAVAILABLE);
  server->open_analysis(*analysis);
  {
    grpc::ClientContext context;
    set_patience(context);
    const auto stream = client.stub().AnalyzeScene(&context, {});
    std::vector<v1::AnalysisProgress> all;
    for (v1::AnalysisProgress progress; stream->Read(&progress);) all.push_back(progress);
    EXPECT_TRUE(stream->Finish().ok());
    ASSERT_EQ(all.size(), 6u);  // offline, asked, finished of two
    EXPECT_EQ(all[0].stage(), v1::AnalysisProgress::OFFLINE);
    EXPECT_EQ(all[1].stage(), v1::AnalysisProgress::OFFLINE);
    EXPECT_EQ(all[5].stage(), v1::AnalysisProgress::FINISHED);
    EXPECT_EQ(all[5].finished(), 2u);
    EXPECT_EQ(all[5].objects(), 2u);
    EXPECT_EQ(all[5].verdict(), v1::AnalysisProgress::ACCEPTED);
    EXPECT_EQ(all[5].record().model(), "fake-1");
  }
  {
    grpc::ClientContext context;
    set_patience(context);
    v1::AnalyzeSceneRequest request;
    request.add_objects("hat");
    const auto stream = client.stub().AnalyzeScene(&context, request);
    v1::AnalysisProgress progress;
    EXPECT_FALSE(stream->Read(&progress));
    EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::NOT_FOUND);
  }
  EXPECT_TRUE(set("wood block", 0.6, reply).ok());
  EXPECT_EQ(reply.parameters().mass_kg().best(), 0.6);
  EXPECT_EQ(set("wood block", -1, reply).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  {
    grpc::ClientContext context;
    set_patience(context);
    v1::AcceptProposalRequest accept;
    accept.set_object("wood block");
    EXPECT_EQ(client.stub().AcceptProposal(&context, accept, &reply).error_code(), grpc::StatusCode::NOT_FOUND);
  }
  grpc::ClientContext context;
  set_patience(context);
  v1::UndoPhysicsRequest undo;
  undo.set_object("wood block");
  EXPECT_TRUE(client.stub().UndoPhysics(&context, undo, &reply).ok());
  EXPECT_EQ(reply.parameters().mass_kg().source(), EstimatedValue::MODEL);
  server->shut_down("done");
}

// Whoever is there and whoever joins later is offered what waits, whoever asked for it and before which start.
TEST_F(LiveAnalysisTest, AProposalIsOfferedToEveryClient) {
  start(weigh_too_much);
  ASSERT_EQ(analyzed("wood block").verdict(), v1::AnalysisProgress::NEEDS_REVIEW);
  analysis.reset();
  loop->stop();
  auto listening = LiveServer::listen("127.0.0.1:0");
  ASSERT_TRUE(listening);
  auto server = std::move(*listening);
  start(weigh_too_much);
  loop->stop();  // no tick is needed for it
  server->open(loop->scene(), *loop);
  server->open_analysis(*analysis);
  const auto joined = [&](RawClient& client) {
    EXPECT_TRUE(client.join().ok());
    v1::ObjectDescription block;
    for (const v1::ObjectDescription& one : client.joined.objects()) {
      if (one.name() == "wood block") block = one;
      EXPECT_TRUE(one.name() == "wood block" || !one.has_proposal()) << one.name();
    }
    return block;
  };
  RawClient watching(server->port()), late(server->port());
  EXPECT_GT(joined(watching).proposal().mass_kg().best(), 2);
  watching.open();
  const auto told = [&] { return watching.read().events(0).object_changed(); };
  const auto accept = [&](bool decline) {
    grpc::ClientContext context;
    set_patience(context);
    v1::AcceptProposalRequest request;
    v1::PhysicsReply reply;
    request.set_object("wood block");
    request.set_decline(decline);
    return late.stub().AcceptProposal(&context, request, &reply).error_code();
  };
  EXPECT_EQ(accept(true), grpc::StatusCode::OK);
  v1::ObjectDescription block = told();
  EXPECT_EQ(block.name(), "wood block");
  EXPECT_FALSE(block.has_proposal());
  EXPECT_FALSE(joined(late).has_proposal());
  EXPECT_EQ(accept(true), grpc::StatusCode::NOT_FOUND);

  ASSERT_EQ(analyzed("wood block").verdict(), v1::AnalysisProgress::NEEDS_REVIEW);
  block = told();
  EXPECT_GT(block.proposal().mass_kg().best(), 2);
  EXPECT_LT(block.physics().mass_kg().best(), 2);  // it has what it had
  EXPECT_TRUE(joined(late).has_proposal());
  EXPECT_EQ(accept(false), grpc::StatusCode::OK);
  EXPECT_FALSE(told().has_proposal());
  watching.cancel();
  server->shut_down("done");
}

// A client that cancels costs no more tokens, and the next in line does not wait for its answers.
TEST_F(LiveAnalysisTest, ACancelledCallStopsAskingAndLetsTheNextOneIn) {
  auto listening = LiveServer::listen("127.0.0.1:0");
  ASSERT_TRUE(listening);
  auto server = std::move(*listening);
  start(weigh);
  endpoint->delay = [](const std::string& name) {
    return name == "sponge" ? std::chrono::milliseconds(0) : std::chrono::milliseconds(std::chrono::minutes(10));
  };
  loop->stop();
  server->open(loop->scene(), *loop);
  server->open_analysis(*analysis);
  RawClient client(server->port());
  grpc::ClientContext hung, next;
  v1::AnalyzeSceneRequest request;
  v1::AnalysisProgress progress;
  request.add_objects("wood block");
  const auto stream = client.stub().AnalyzeScene(&hung, request);
  while (progress.stage() != v1::AnalysisProgress::ASKED) ASSERT_TRUE(stream->Read(&progress));
  hung.TryCancel();
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
  request.set_objects(0, "sponge");
  set_patience(next);
  const auto second = client.stub().AnalyzeScene(&next, request);
  while (second->Read(&progress)) {
  }
  EXPECT_TRUE(second->Finish().ok());
  EXPECT_EQ(progress.stage(), v1::AnalysisProgress::FINISHED);
  EXPECT_EQ(progress.object(), "sponge");
  EXPECT_EQ(progress.verdict(), v1::AnalysisProgress::ACCEPTED) << progress.message();
  server->shut_down("done");
}

TEST_F(LiveAnalysisTest, AServerShutsDownWhileAModelHangs) {
  auto listening = LiveServer::listen("127.0.0.1:0");
  ASSERT_TRUE(listening);
  auto server = std::move(*listening);
  start(weigh, std::chrono::minutes(10));
  loop->stop();
  server->open(loop->scene(), *loop);
  server->open_analysis(*analysis);
  RawClient client(server->port());
  grpc::ClientContext context;
  const auto stream = client.stub().AnalyzeScene(&context, {});
  v1::AnalysisProgress progress;
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(stream->Read(&progress));
  EXPECT_EQ(progress.stage(), v1::AnalysisProgress::ASKED);
  server->shut_down("done");
  EXPECT_FALSE(stream->Read(&progress));
  EXPECT_FALSE(stream->Finish().ok());
}

}  // namespace
}  // namespace livegs
