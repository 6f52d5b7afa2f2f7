// SPDX-License-Identifier: Apache-2.0
#include "viewer/author/scene_editor.h"

#include <gtest/gtest.h>

namespace livegs {
namespace {

class Editors : public ::testing::Test {
 protected:
  Editors() {
    v1::SceneDocument document;
    document.set_revision(3);
    document.set_file("room.scene.json");
    for (const char* name : {"cup", "plate", "lamp"}) {
      v1::Object& object = *document.mutable_scene()->add_objects();
      object.set_name(name);
      object.set_asset(std::string(name) + ".ply");
      EditedObject running;
      running.pose.position_m = {0.1 * static_cast<double>(objects_.size()), 0, 0};
      running.centre_m = running.pose.position_m;
      running.longest_side_m = 0.2;
      running.estimated_label = "mug";
      running.confidence = 0.6;
      objects_[name] = running;
    }
    for (const int index : {0, 1}) document.mutable_scene()->mutable_objects(index)->set_group("table");
    editor_.take(document);
  }
  // The only call of these actions, an edit.
  v1::EditSceneRequest edit(const SceneActions& actions) {
    const auto calls = editor_.act(actions, objects_, {0, 0, 1}, {});
    EXPECT_EQ(calls.size(), 1u);
    const auto* request = calls.empty() ? nullptr : std::get_if<v1::EditSceneRequest>(&calls.front());
    EXPECT_NE(request, nullptr);
    return request ? *request : v1::EditSceneRequest();
  }
  SceneEditor editor_;
  SceneEditor::Objects objects_;
};

TEST_F(Editors, AGroupIsSelectedTogether) {
  editor_.select("cup", false);
  EXPECT_EQ(editor_.selected(), (std::set<std::string>{"cup", "plate"}));
  editor_.select("lamp", true);
  EXPECT_EQ(editor_.selected().size(), 3u);
  editor_.select("cup", true);
  EXPECT_EQ(editor_.selected(), std::set<std::string>{"lamp"}) << "a second time takes it out";
  EXPECT_TRUE(editor_.shown(objects_).fields.has_value());
  editor_.select("", false);
  EXPECT_FALSE(editor_.shown(objects_).fields.has_value());
}

TEST_F(Editors, FieldsSetWhatWasTyped) {
  editor_.select("lamp", false);
  SceneActions actions;
  actions.position_m = {{1, 2, 3}};
  const v1::EditSceneRequest moved = edit(actions);
  EXPECT_EQ(moved.objects(0).object(), "lamp");
  EXPECT_EQ(moved.objects(0).value().pose().position_m(1), 2);
  EXPECT_EQ(moved.objects(0).fields(0), "pose");

  actions = {};
  actions.label = "paper lamp";
  EXPECT_EQ(edit(actions).objects(0).value().label(), "paper lamp");
  actions = {};
  actions.behavior = 3;
  const v1::EditSceneRequest soft = edit(actions);
  EXPECT_EQ(soft.objects(0).value().physics().behavior(), v1::Physics::ELASTIC);
  EXPECT_EQ(soft.objects(0).fields(0), "physics.behavior");
  actions = {};
  actions.longest_side_m = 0.5;
  EXPECT_EQ(edit(actions).objects(0).longest_side_m(), 0.5);
}

TEST_F(Editors, StepsOnSeveralObjectsAreOne) {
  editor_.select("cup", false);  // and the plate
  SceneActions actions;
  actions.remove = true;
  EXPECT_EQ(edit(actions).objects_size(), 2);
  actions = {};
  actions.duplicate = true;
  const v1::EditSceneRequest copies = edit(actions);
  ASSERT_EQ(copies.objects_size(), 2);
  EXPECT_EQ(copies.objects(0).copy_of(), "cup");
  EXPECT_GT(copies.objects(0).value().pose().position_m(0), 0.1) << "beside the original";
  actions = {};
  actions.drop = true;
  EXPECT_TRUE(edit(actions).objects(1).drop());
}

TEST_F(Editors, TheGizmoMovesTheSelectionAndEndsInOneStep) {
  const Camera camera = look_at({0, 1, 3}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.7, 800, 600);
  editor_.select("cup", false);
  editor_.set_tool(1);
  const Eigen::Vector3d pivot = editor_.pivot_m(objects_).value();
  const auto handles = Gizmo::handles(GizmoTool::Move, camera, pivot);
  const Eigen::Vector2d from = 0.5 * (handles[0].line_px[0] + handles[0].line_px[1]);
  EXPECT_FALSE(editor_.press(camera, {3, 3}, objects_)) << "the mouse is on no handle";
  ASSERT_TRUE(editor_.press(camera, from, objects_));
  const Eigen::Vector2d to = from + Eigen::Vector2d(60, 0);
  const auto carried = editor_.drag(camera, to, false);
  ASSERT_EQ(carried.size(), 2u);
  const auto& carry = std::get<v1::CarryObjectRequest>(carried[0]);
  const auto released = editor_.release(camera, to, false);
  ASSERT_EQ(released.size(), 1u);
  const auto& request = std::get<v1::EditSceneRequest>(released[0]);
  ASSERT_EQ(request.objects_size(), 2);
  EXPECT_EQ(request.objects(0).value().pose().position_m(0), carry.pose().position_m(0))
      << "where it was carried";
  EXPECT_GT(carry.pose().position_m(0), 0.05);
  EXPECT_EQ(request.title(), "move 2 objects");
  EXPECT_FALSE(editor_.dragging());
}

TEST_F(Editors, LockedObjectsHaveNoGizmo) {
  v1::SceneDocument document = editor_.document();
  document.mutable_scene()->mutable_objects(2)->set_locked(true);
  editor_.take(document);
  editor_.select("lamp", false);
  editor_.set_tool(1);
  EXPECT_FALSE(editor_.pivot_m(objects_));
}

TEST_F(Editors, AnUnsureEstimateAsks) {
  editor_.select("lamp", false);
  EXPECT_EQ(editor_.shown(objects_).fields->label_hint, "mug? (60 %)");
  objects_["lamp"].confidence = 0.12;
  EXPECT_EQ(editor_.shown(objects_).fields->label_hint, "unknown: say what it is");
}

TEST_F(Editors, ANewRevisionIsFetchedOnce) {
  EXPECT_FALSE(editor_.see_revision(3)) << "it is known";
  EXPECT_TRUE(editor_.see_revision(4));
  EXPECT_FALSE(editor_.see_revision(4)) << "it is under way";
  EXPECT_TRUE(editor_.see_revision(5));
  EXPECT_FALSE(editor_.see_revision(0)) << "this server cannot edit";
}

TEST_F(Editors, ASceneWithoutAFileAsksWhere) {
  v1::SceneDocument document = editor_.document();
  document.clear_file();
  editor_.take(document);
  SceneActions actions;
  actions.save = true;
  EXPECT_TRUE(editor_.act(actions, objects_, {0, 0, 0}, {}).empty());
  EXPECT_EQ(editor_.shown(objects_).notice, "This scene has no file yet: use Save as.");
  actions = {};
  actions.save_as = "kitchen";
  const auto calls = editor_.act(actions, objects_, {0, 0, 0}, {});
  ASSERT_EQ(calls.size(), 1u);
  EXPECT_EQ(std::get<v1::SaveSceneRequest>(calls[0]).file(), "kitchen");
}

TEST_F(Editors, DroppedFilesBecomeObjects) {
  const auto calls = editor_.drop_files({"/a/cup.ply", "/b/jug.spz"}, {1, 0, 2});
  ASSERT_EQ(calls.size(), 2u);
  const auto& upload = std::get<UploadCall>(calls[1]);
  EXPECT_EQ(upload.file, "/b/jug.spz");
  EXPECT_TRUE(upload.edit.drop());
  EXPECT_TRUE(upload.edit.value().standing());
  EXPECT_NE(upload.edit.value().pose().position_m(0),
            std::get<UploadCall>(calls[0]).edit.value().pose().position_m(0))
      << "not in each other";
}

}  // namespace
}  // namespace livegs
