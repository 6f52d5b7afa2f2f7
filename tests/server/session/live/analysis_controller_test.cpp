// SPDX-License-Identifier: Apache-2.0
// Answers that arrive while a scene runs, and a model that does not answer.
#include "core/log.h"
#include "server/session/live/analysis_controller_fixture.h"
#include "server/session/rpc/raw_client.h"
#include "session/live/run_controller.h"
#include "session/rpc/grpc_server.h"

namespace livegs {
namespace {

using v1::EstimatedValue;

TEST_F(AnalysisControllerTest, AcceptedAnswerIsAppliedInOneTick) {
  start(weigh);
  analysis->begin();
  ASSERT_TRUE(changes_to("wood block", by_model));
  ASSERT_TRUE(changes_to("sponge", by_model));
  EXPECT_EQ(changes_of("wood block"), 1u);
  EXPECT_EQ(changes_of("given"), 0u);  // its behaviour is given: no question was sent
  for (const std::string& line : endpoint->asked()) {
    EXPECT_EQ(line.find("given <"), std::string::npos) << line;
    // the questions about the others contain it
    EXPECT_NE(line.find(" given!1.000000"), std::string::npos) << line;
  }
  loop->stop();
  const SceneObject* block = loop->scene().find("wood block");
  EXPECT_EQ(block->mass_kg, block->physics.mass_kg().best());
  EXPECT_EQ(loop->scene().world().material(block->id)->mass_kg, block->mass_kg);
  // Between the model's 450 g and the estimate.
  EXPECT_GE(block->mass_kg, std::min(0.45, offline_kg["wood block"]) - 1e-9);
  EXPECT_LE(block->mass_kg, std::max(0.45, offline_kg["wood block"]) + 1e-9);
  // The answer is stored with the asset or the scene, so the next start sends no question.
  for (const char* name : {"sponge.physics.json", "open.scene.physics.wood%20block.json"}) {
    const auto kept = read_physics_file(folder / name);
    ASSERT_TRUE(kept);
    EXPECT_EQ(kept->analysis().model(), "fake-1") << name;
  }
  EXPECT_TRUE(by_model(*open_scene(folder).find("sponge")));
  EXPECT_TRUE(by_model(*open_scene(folder).find("wood block")));
}

// Decisions made during a reset apply from its first tick, and the file is read again.
TEST_F(AnalysisControllerTest, ResetKeepsDecisionsAndReadsTheFile) {
  start(nullptr);
  v1::Physics edit;
  edit.set_mass_kg(0.7);
  RunController run(
      *loop,
      [&](uint32_t first_id) -> Result<Scene> {
        Scene reloaded = open_scene(folder, R"({ "friction": 0.9 })", "0.2", first_id);
        EXPECT_TRUE(analysis->set_physics("wood block", edit));
        return reloaded;
      },
      [&](Scene reloaded) { analysis->replace(std::move(reloaded)); });
  v1::ControlRunRequest reset;
  reset.set_reset(true);
  ASSERT_TRUE(run.control(reset));
  ASSERT_TRUE(log.wait([](const auto& ticks) { return !ticks.empty() && ticks.back().run.resets == 1; }));
  for (const TickResult& tick : log.ticks()) {
    if (!tick.scene_is_new) continue;
    const auto block = std::find_if(tick.added.begin(), tick.added.end(),
                                    [](const auto& one) { return one.name == "wood block"; });
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

// Edits of the user are part of the next question and of its plausibility check.
TEST_F(AnalysisControllerTest, EditsAreUsedInTheNextAnalysis) {
  std::mutex mutex;
  std::string given;
  start([&](const AnalysisQuestion& question, const ToolBox& tools, int turn) -> Result<std::string> {
    std::lock_guard lock(mutex);
    const auto slot = question.slots.find("told");
    given = slot == question.slots.end() ? "" : slot->second;
    auto answer = nlohmann::json::parse(*weigh(question, tools, turn));
    answer["mass_g"] = {{"low", 4500}, {"best", 5000}, {"high", 5500}};
    return answer.dump();
  });
  EXPECT_FALSE(analysis->accept_proposal("wood block"));
  EXPECT_EQ(analyzed("wood block").verdict(), v1::AnalysisProgress::NEEDS_REVIEW);  // ten times the estimate
  EXPECT_EQ(given, "");
  // The user may accept it anyway, and undo that.
  const auto accepted = analysis->accept_proposal("wood block");
  ASSERT_TRUE(accepted) << accepted.error().message;
  EXPECT_EQ(accepted->parameters().mass_kg().source(), EstimatedValue::MODEL);
  EXPECT_GT(accepted->parameters().mass_kg().best(),
            2);  // fused from the answer, 5 kg, and the estimate, a tenth of it
  ASSERT_TRUE(changes_to("wood block", [](const SceneObject& one) { return one.mass_kg > 2; }));
  ASSERT_TRUE(analysis->undo_physics("wood block", false));
  v1::Physics edit;
  edit.set_mass_kg(5);
  ASSERT_TRUE(analysis->set_physics("wood block", edit));
  const auto last = analyzed("wood block");
  EXPECT_EQ(last.verdict(), v1::AnalysisProgress::ACCEPTED) << last.message();
  EXPECT_EQ(last.parameters().mass_kg().source(), EstimatedValue::PERSON);
  EXPECT_EQ(last.parameters().friction().source(), EstimatedValue::MODEL);
  EXPECT_EQ(given, "mass_kg 5");
}

TEST(BodyTypeLock, DefersChangesOfBodyTypeToTheNextLoad) {
  v1::PhysicalParameters physics;
  physics.set_behavior(v1::Physics::RIGID);
  physics.set_fragile(true);
  EXPECT_TRUE(lock_body_type({v1::Physics::RIGID, true}, physics).empty());
  const auto uncut = lock_body_type({v1::Physics::RIGID, false}, physics);
  ASSERT_EQ(uncut.size(), 1u);
  EXPECT_EQ(uncut[0], "fragile: no effect until the scene is reloaded");
  EXPECT_EQ(lock_body_type({v1::Physics::ELASTIC, false}, physics).size(), 2u);
  EXPECT_EQ(physics.behavior(), v1::Physics::ELASTIC);
}

TEST_F(AnalysisControllerTest, ReportsEditsThatNeedAReload) {
  start(nullptr);
  v1::Physics edit;
  edit.set_behavior(v1::Physics::ELASTIC);
  edit.set_friction(0.77);
  const auto reply = analysis->set_physics("wood block", edit);
  ASSERT_TRUE(reply) << reply.error().message;
  ASSERT_EQ(reply->warnings_size(), 1);
  EXPECT_EQ(reply->warnings(0), "behavior: stays RIGID until the scene is reloaded, then changes to ELASTIC");
  EXPECT_EQ(reply->parameters().behavior(), v1::Physics::RIGID);
  ASSERT_TRUE(changes_to("wood block", [](const SceneObject& one) {
    return one.physics.friction().best() == 0.77 && one.physics.behavior() == v1::Physics::RIGID &&
           one.physics.behavior_reason().find("reloaded") != std::string::npos;
  }));
}

TEST_F(AnalysisControllerTest, HangingModelDelaysNeitherTicksNorShutdown) {
  start(weigh, std::chrono::minutes(10));
  analysis->begin();
  ASSERT_TRUE(log.wait([&](const auto& ticks) { return ticks.size() > 20; }));
  analysis.reset();  // within milliseconds; otherwise the test times out
  EXPECT_EQ(changes_of("wood block"), 0u);
}

// Over gRPC, as clients see it.
TEST_F(AnalysisControllerTest, ClientsFollowAnalysesAndEdit) {
  auto listening = GrpcServer::listen("127.0.0.1:0");
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
    ASSERT_EQ(all.size(), 6u);  // offline, asked and finished for two objects
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
    EXPECT_EQ(client.stub().AcceptProposal(&context, accept, &reply).error_code(),
              grpc::StatusCode::NOT_FOUND);
  }
  grpc::ClientContext context;
  set_patience(context);
  v1::UndoPhysicsRequest undo;
  undo.set_object("wood block");
  EXPECT_TRUE(client.stub().UndoPhysics(&context, undo, &reply).ok());
  EXPECT_EQ(reply.parameters().mass_kg().source(), EstimatedValue::MODEL);
  server->shut_down("done");
}

// A cancelled request uses no further tokens and does not delay the next one.
TEST_F(AnalysisControllerTest, CancelledCallStopsAndFreesTheQueue) {
  auto listening = GrpcServer::listen("127.0.0.1:0");
  ASSERT_TRUE(listening);
  auto server = std::move(*listening);
  start(weigh);
  endpoint->delay = [](const std::string& name) {
    return name == "sponge" ? std::chrono::milliseconds(0)
                            : std::chrono::milliseconds(std::chrono::minutes(10));
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

TEST_F(AnalysisControllerTest, ServerShutsDownWhileAModelHangs) {
  auto listening = GrpcServer::listen("127.0.0.1:0");
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
