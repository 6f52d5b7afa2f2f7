// SPDX-License-Identifier: Apache-2.0
// Decisions of the user on proposals while a scene runs.
#include "core/log.h"
#include "server/session/live/analysis_controller_fixture.h"
#include "server/session/rpc/raw_client.h"
#include "session/rpc/grpc_server.h"

namespace livegs {
namespace {

using v1::EstimatedValue;

// An undone answer is not requested again at the next start. Another question is.
TEST_F(AnalysisControllerTest, UndoneAnswerIsNotRequestedAgain) {
  start(weigh);
  analysis->begin();
  ASSERT_TRUE(changes_to("wood block", by_model));
  ASSERT_TRUE(changes_to("sponge", by_model));
  ASSERT_TRUE(analysis->undo_physics("wood block", false));
  v1::Physics edit;
  edit.set_friction(0.5);
  ASSERT_TRUE(analysis->set_physics("wood block", edit));  // a later edit makes no difference
  analysis.reset();
  loop->stop();

  start(weigh);
  set_log_level(LogLevel::Info);
  testing::internal::CaptureStderr();
  analysis->begin();
  const std::string logged = testing::internal::GetCapturedStderr();
  EXPECT_NE(logged.find("wood block: skipped: its answer was undone or declined"), std::string::npos)
      << logged;
  EXPECT_EQ(logged.find("objects are sent to"), std::string::npos) << logged;
  EXPECT_EQ(analyzed("wood block").verdict(), v1::AnalysisProgress::ACCEPTED);  // requested by the user
  EXPECT_EQ(endpoint->asked().size(), 1u);
  analysis.reset();
  loop->stop();

  // An undone edit is not an undone answer. Deleting the sidecar deletes all decisions.
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

// A proposal from the analysis at start is logged and does not change the scene.
TEST_F(AnalysisControllerTest, ProposalAtStartIsLoggedAndWaits) {
  const auto touched = [&] {
    for (const TickResult& tick : log.ticks()) {
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
  EXPECT_EQ(analyzed("sponge").verdict(),
            v1::AnalysisProgress::ACCEPTED);  // the log lines of the start are written by now
  analysis.reset();
  loop->stop();
  EXPECT_FALSE(touched());
  std::string logged = testing::internal::GetCapturedStderr();
  EXPECT_NE(logged.find("analysis: wood block: needs review: mass_g.best: 5000 g is unlikely"),
            std::string::npos)
      << logged;
  EXPECT_NE(
      logged.find(
          "kept as a proposal; accept it in the window or with livegs analyze --accept; decline it there"),
      std::string::npos);
  EXPECT_NE(logged.find("analysis: sponge: accepted"), std::string::npos) << logged;

  // The next start sends no question and logs that the proposal exists.
  testing::internal::CaptureStderr();
  start(weigh_too_much);
  analysis->begin();
  logged = testing::internal::GetCapturedStderr();
  EXPECT_NE(logged.find("wood block: a proposal from an earlier run waits"), std::string::npos) << logged;
  EXPECT_TRUE(endpoint->asked().empty());
  std::vector<std::string> offered;
  analysis->watch_proposals([&](const std::string& object, const v1::PhysicsFile* proposal) {
    offered.push_back(object + (proposal ? " waits" : " waits no longer"));
  });
  ASSERT_TRUE(analysis->accept_proposal("wood block"));
  analysis->watch_proposals({});
  EXPECT_EQ(offered, (std::vector<std::string>{"wood block waits", "wood block waits no longer"}));
  EXPECT_TRUE(changes_to("wood block", [](const SceneObject& one) { return one.mass_kg > 2; }));
}

// A sleeping, frictionless object stays so while a proposal waits.
TEST_F(AnalysisControllerTest, WaitingProposalLeavesTheSceneUnchanged) {
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

// The decision is final: neither this server nor the next one sends the question again.
TEST_F(AnalysisControllerTest, DeclineOrEditEndsAProposal) {
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
    analysis->watch_proposals([&](const std::string&, const v1::PhysicsFile*) { offered = true; });
    EXPECT_FALSE(offered);
    analysis->begin();
    ASSERT_TRUE(changes_to("sponge", by_model));
    for (const std::string& line : endpoint->asked()) EXPECT_FALSE(line.starts_with("wood block")) << line;
    analysis.reset();
    loop->stop();
    for (const char* name : {"open.scene.physics.wood%20block", "sponge.physics"}) {
      for (const char* ending : {".json", ".log"})
        std::filesystem::remove(folder / (std::string(name) + ending));
    }
  }
}

TEST_F(AnalysisControllerTest, EditsAreLockedAndCanBeUndone) {
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
    EXPECT_EQ(last.parameters().mass_kg().best(), 0.7);  // locked by the edit
    EXPECT_EQ(last.parameters().friction().source(), EstimatedValue::MODEL);

    ASSERT_TRUE(analysis->undo_physics(name, false));  // undoes the analysis
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

// A shape of a scene without a file.
TEST(PhysicsOverrides, NotesOnceThatValuesAreNotStored) {
  PhysicsOverrides decided("");
  std::string note;
  v1::Physics edit;
  edit.set_mass_kg(0.7);
  ASSERT_TRUE(decided.edit(edit, "", note));
  EXPECT_EQ(note,
            "the object has no file for its values: they are kept until the server ends; add them to the "
            "scene file");
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

// A name set by the user applies from then on, also to the next question.
TEST_F(AnalysisControllerTest, NameChangesTheEstimate) {
  start(nullptr);
  const auto renamed = analysis->set_physics("sponge", {}, "steel bolt");
  ASSERT_TRUE(renamed) << renamed.error().message;
  EXPECT_EQ(renamed->parameters().material(), "carbon steel");
  ASSERT_TRUE(
      changes_to("sponge", [](const SceneObject& one) { return one.physics.material() == "carbon steel"; }));
  EXPECT_EQ(read_physics_file(folder / "sponge.physics.json")->name(), "steel bolt");
  const auto undone = analysis->undo_physics("sponge", false);
  ASSERT_TRUE(undone);
  EXPECT_NE(undone->parameters().material(), "carbon steel");
}

TEST_F(AnalysisControllerTest, BadEditsNameTheField) {
  start(nullptr);
  v1::Physics edit;
  edit.set_friction(-1);
  EXPECT_EQ(analysis->set_physics("wood block", edit).error().message,
            "physics.friction: is -1; it must be between 0 and 2");
  edit.set_friction(0.5);
  EXPECT_NE(analysis->set_physics("hat", edit).error().message.find("available: wood block, given, sponge"),
            std::string::npos);
}

TEST_F(AnalysisControllerTest, ReportsEditsOverriddenByTheScene) {
  start(nullptr);
  v1::Physics edit;
  edit.set_mass_kg(3.0);
  const auto reply = analysis->set_physics("given", edit);
  ASSERT_TRUE(reply) << reply.error().message;
  ASSERT_EQ(reply->warnings_size(), 1);
  EXPECT_EQ(reply->warnings(0),
            "the edit of mass_kg has no effect, because the scene file sets it; remove it there to edit it "
            "here");
}

// Waiting proposals are offered to all clients, present and future, regardless of who requested them and in
// which run.
TEST_F(AnalysisControllerTest, ProposalIsOfferedToEveryClient) {
  start(weigh_too_much);
  ASSERT_EQ(analyzed("wood block").verdict(), v1::AnalysisProgress::NEEDS_REVIEW);
  analysis.reset();
  loop->stop();
  auto listening = GrpcServer::listen("127.0.0.1:0");
  ASSERT_TRUE(listening);
  auto server = std::move(*listening);
  start(weigh_too_much);
  loop->stop();  // no tick is needed
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
  // The reason is listed in the warnings of the object.
  const auto reasons = [](const v1::ObjectDescription& object) {
    return std::count_if(object.warnings().begin(), object.warnings().end(), [](const std::string& one) {
      return one.starts_with("needs review: mass_g.best: 5000 g is unlikely");
    });
  };
  v1::ObjectDescription block = joined(watching);
  EXPECT_GT(block.proposal().mass_kg().best(), 2);
  EXPECT_EQ(reasons(block), 1);  // from the sidecar's log
  watching.open();
  const auto next_change = [&] { return watching.read().events(0).object_changed(); };
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
  block = next_change();
  EXPECT_EQ(block.name(), "wood block");
  EXPECT_FALSE(block.has_proposal());
  EXPECT_EQ(reasons(block), 0);
  EXPECT_FALSE(joined(late).has_proposal());
  EXPECT_EQ(accept(true), grpc::StatusCode::NOT_FOUND);

  ASSERT_EQ(analyzed("wood block").verdict(), v1::AnalysisProgress::NEEDS_REVIEW);
  block = next_change();
  EXPECT_GT(block.proposal().mass_kg().best(), 2);
  EXPECT_EQ(reasons(block), 1);                    // from the latest answer
  EXPECT_LT(block.physics().mass_kg().best(), 2);  // unchanged
  EXPECT_EQ(reasons(joined(late)), 1);
  EXPECT_EQ(accept(false), grpc::StatusCode::OK);
  block = next_change();
  EXPECT_FALSE(block.has_proposal());
  EXPECT_EQ(reasons(block), 0);
  watching.cancel();
  server->shut_down("done");
}

}  // namespace
}  // namespace livegs
