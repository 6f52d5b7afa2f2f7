// SPDX-License-Identifier: Apache-2.0
// Scenes that are built through the server's calls: steps, undo, two authors, crashes.
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <thread>

#include "splat/image.h"
#include "system/programs/programs_fixture.h"
#include "system/support/author_server.h"

namespace livegs {
namespace {

using google::protobuf::util::MessageDifferencer;

class Authoring : public Programs {
 protected:
  void SetUp() override {
    server_ = std::make_unique<AuthorServer>(folder_.path());
    for (const char* asset : {"cup.ply", "pillow.ply", "stool.ply"})
      std::filesystem::copy(folder_ / "sample" / asset, folder_ / "made" / asset);
  }
  void serve(bool fresh) {
    server_->start(fresh);
    author_ = &server_->control();
  }
  v1::SceneDocument document() {
    auto scene = author_->scene();
    EXPECT_TRUE(scene) << scene.error().message;
    return scene ? *scene : v1::SceneDocument();
  }
  std::vector<std::string> edit(const v1::EditSceneRequest& request) {
    const auto done = author_->edit_scene(request);
    EXPECT_TRUE(done) << done.error().message;
    return done ? std::vector<std::string>(done->objects().begin(), done->objects().end())
                : std::vector<std::string>(1);
  }
  static v1::EditSceneRequest one(const std::string& object,
                                  const std::function<void(v1::ObjectEdit&)>& change) {
    v1::EditSceneRequest request;
    request.add_objects()->set_object(object);
    change(*request.mutable_objects(0));
    return request;
  }
  static v1::EditSceneRequest added(const std::string& asset, double x) {
    return one("", [&](v1::ObjectEdit& edit) {
      edit.mutable_value()->set_asset(asset);
      edit.mutable_value()->set_standing(true);
      for (const double coordinate : {x, 0.0, 0.0})
        edit.mutable_value()->mutable_pose()->add_position_m(coordinate);
      edit.set_drop(true);
    });
  }
  static v1::EditSceneRequest moved(const std::string& object, double x, double z) {
    return one(object, [&](v1::ObjectEdit& edit) {
      for (const double coordinate : {x, 1.0, z})
        edit.mutable_value()->mutable_pose()->add_position_m(coordinate);
      edit.add_fields("pose");
    });
  }
  void expect_undo(const std::string& title) {
    while (document().undo() != title) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  // A value that was set by hand goes back to its estimate as a step of the log. Takes all steps back.
  void expect_return_to_the_estimate(const std::string& object) {
    const v1::SceneDocument before = document();
    const auto mass = [&](double friction) {  // the reply of another edit has all values
      v1::Physics rough;
      rough.set_friction(friction);
      const auto reply = author_->set_physics(object, rough);
      EXPECT_TRUE(reply) << reply.error().message;
      expect_undo("edit values of " + object);
      EXPECT_TRUE(author_->undo_edit(false));
      return reply ? reply->parameters().mass_kg() : v1::EstimatedValue();
    };
    const v1::EstimatedValue estimate = mass(0.7);
    EXPECT_EQ(estimate.source(), v1::EstimatedValue::OFFLINE);
    v1::Physics heavy;
    heavy.set_mass_kg(3);
    ASSERT_TRUE(author_->set_physics(object, heavy));
    expect_undo("edit values of " + object);
    edit(one(object, [](v1::ObjectEdit& edit) {
      edit.add_fields("physics.mass_kg");
      edit.add_fields("physics.density_kg_m3");
    }));
    EXPECT_EQ(document().undo(), "return to the estimate of " + object);
    EXPECT_EQ(mass(0.8).best(), estimate.best());
    ASSERT_TRUE(author_->undo_edit(false));
    EXPECT_EQ(mass(0.9).best(), 3);
    const auto none =
        author_->edit_scene(one(object, [](v1::ObjectEdit& edit) { edit.add_fields("physics.plasticity"); }));
    ASSERT_FALSE(none);
    EXPECT_NE(none.error().message.find("set by hand"), std::string::npos) << none.error().message;
    ASSERT_TRUE(author_->undo_edit(false));
    EXPECT_EQ(document().undo(), before.undo());
    EXPECT_TRUE(MessageDifferencer::Equals(document().scene(), before.scene()));
  }
  std::unique_ptr<AuthorServer> server_;
  SceneControl* author_ = nullptr;
};

TEST_F(Authoring, ASceneIsBuiltSavedAndOpenedTheSame) {
  serve(true);
  const auto listed = author_->assets();
  ASSERT_TRUE(listed);
  ASSERT_EQ(listed->assets_size(), 3);
  EXPECT_EQ(listed->assets(0).path(), "cup.ply");
  EXPECT_GT(listed->labels_size(), 100);
  const auto uploaded = author_->upload_asset(folder_ / "sample/hat.ply");
  ASSERT_TRUE(uploaded) << uploaded.error().message;
  EXPECT_EQ(*uploaded, "hat.ply");
  ASSERT_EQ(author_->upload_asset(folder_ / "sample/hat.ply").value(), "hat.ply") << "it is not stored twice";

  EXPECT_EQ(edit(added("cup.ply", 0))[0], "cup");
  ASSERT_NO_FATAL_FAILURE(expect_return_to_the_estimate("cup"));
  EXPECT_EQ(edit(added("pillow.ply", 1))[0], "pillow");
  EXPECT_EQ(edit(added("stool.ply", 2))[0], "stool");
  EXPECT_EQ(edit(added("hat.ply", 3))[0], "hat");
  edit(one("cup", [](v1::ObjectEdit& edit) {
    edit.mutable_value()->set_name("mug");
    edit.mutable_value()->set_label("stoneware mug");
    edit.add_fields("name");
    edit.add_fields("label");
  }));
  edit(moved("stool", 0.1 + 0.2, 1.0 / 3.0));
  edit(one("stool", [](v1::ObjectEdit& edit) { edit.set_drop(true); }));
  edit(one("pillow", [](v1::ObjectEdit& edit) { edit.set_longest_side_m(0.7); }));
  edit(one("hat", [](v1::ObjectEdit& edit) { edit.set_remove(true); }));
  ASSERT_EQ(document().scene().objects_size(), 3);
  ASSERT_TRUE(author_->undo_edit(false));
  ASSERT_EQ(document().scene().objects_size(), 4) << "the hat is back";
  v1::Physics soft;
  soft.set_behavior(v1::Physics::ELASTIC);
  soft.set_youngs_modulus_pa(3e4);
  ASSERT_TRUE(author_->set_physics("pillow", soft));
  expect_undo("edit values of pillow");
  v1::EditSceneRequest background;
  background.set_background(true);
  const Eigen::Vector3f stated(0.2f, 0.4f, 0.6f);
  for (const float part : stated) background.mutable_scene()->add_background_rgb(part);
  edit(background);
  EXPECT_FALSE(author_->save_scene({}).value().file().empty());
  const v1::SceneDocument saved = document();
  EXPECT_FALSE(saved.unsaved());
  server_->stop();

  serve(false);
  EXPECT_TRUE(MessageDifferencer::Equals(document().scene(), saved.scene())) << "to the bit";
  const auto& mug = saved.scene().objects(0);
  EXPECT_EQ(mug.label(), "stoneware mug");
  EXPECT_NEAR(mug.pose().position_m(0), 0, 1e-9);

  // Offscreen pictures have the background.
  Program client(client_words(server_->port(), {"--seconds", "0.5", "--no-video", "--every", "0"}));
  ASSERT_EQ(client.wait(), 0) << client.err();
  const auto first = read_png(folder_ / "view/first.png");
  ASSERT_TRUE(first) << first.error().message;
  const float* corner = first->at(0, 0);
  EXPECT_LE((Eigen::Vector3f(corner[0], corner[1], corner[2]) - stated).cwiseAbs().maxCoeff(),
            0.5f / 255 + 1e-6f);
}

TEST_F(Authoring, AKilledServerLosesAtMostTheStepUnderWay) {
  serve(true);
  std::vector<v1::EditSceneRequest> steps = {
      added("cup.ply", 0), moved("cup", 0.3, 0.1), added("pillow.ply", 1),
      one("pillow", [](v1::ObjectEdit& edit) { edit.set_remove(true); })};
  for (size_t i = 0; i < steps.size(); ++i) {
    edit(steps[i]);
    const v1::Scene before = document().scene();
    server_->kill();
    if (i == 0)
      EXPECT_FALSE(std::filesystem::exists(folder_ / "made/room.scene.json")) << "nothing was saved";
    serve(i < steps.size());  // there is no scene file until a save
    EXPECT_TRUE(MessageDifferencer::Equals(document().scene(), before)) << "after step " << i;
    EXPECT_TRUE(document().unsaved());
  }
}

TEST_F(Authoring, TwoAuthorsShareOneLog) {
  serve(true);
  edit(added("cup.ply", 0));
  edit(added("pillow.ply", 1));
  const v1::Scene before = document().scene();
  constexpr int kSteps = 12;
  const auto work = [&](const std::string& object, double z) {
    SceneControl own(server_->address());
    for (int i = 1; i <= kSteps; ++i) {
      const auto done = own.edit_scene(moved(object, 0.05 * i, z));
      EXPECT_TRUE(done) << done.error().message;
    }
  };
  std::thread first(work, "cup", 1.0), second(work, "pillow", 2.0);
  first.join();
  second.join();
  const v1::Scene both = document().scene();
  EXPECT_EQ(both.objects(0).pose().position_m(0), 0.05 * kSteps);
  EXPECT_EQ(both.objects(1).pose().position_m(0), 0.05 * kSteps);
  EXPECT_EQ(SceneControl(server_->address()).scene().value().revision(), document().revision())
      << "both see the same";
  for (int i = 0; i < 2 * kSteps; ++i) ASSERT_TRUE(author_->undo_edit(false));
  EXPECT_TRUE(MessageDifferencer::Equals(document().scene(), before)) << "whoever made the steps";
  for (int i = 0; i < 2 * kSteps; ++i) ASSERT_TRUE(author_->undo_edit(true));
  EXPECT_TRUE(MessageDifferencer::Equals(document().scene(), both));
}

TEST_F(Authoring, BadEditsChangeNothing) {
  serve(true);
  edit(added("cup.ply", 0));
  const v1::SceneDocument before = document();
  const auto refusal = [&](const v1::EditSceneRequest& request) {
    const auto done = author_->edit_scene(request);
    return done ? "accepted" : done.error().message;
  };
  EXPECT_NE(refusal(added("none.ply", 0)).find("none.ply"), std::string::npos);
  EXPECT_NE(refusal(added("../sample/hat.ply/..", 0)), "accepted");
  EXPECT_NE(refusal(one("cup",
                        [](v1::ObjectEdit& edit) {
                          edit.mutable_value()->set_material("unobtainium");
                          edit.add_fields("material");
                        }))
                .find("is not in the material table"),
            std::string::npos);
  v1::EditSceneRequest half = moved("cup", 1, 1);  // the second edit fails, so the first is not made
  half.add_objects()->set_object("jug");
  EXPECT_NE(refusal(half).find("\"jug\" is not in the scene"), std::string::npos);
  EXPECT_FALSE(author_->upload_asset(folder_.write("bad.ply", "not a splat")));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "made/bad.ply"));
  EXPECT_FALSE(author_->upload_asset(folder_.write("bad.sh", "rm")));
  EXPECT_EQ(document().revision(), before.revision());
  EXPECT_TRUE(MessageDifferencer::Equals(document().scene(), before.scene()));
}

}  // namespace
}  // namespace livegs
