// SPDX-License-Identifier: GPL-3.0-or-later
// Edits of a running scene.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "livegs/v1/recording.pb.h"
#include "scene/build/build_cache.h"
#include "scene/scene.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

constexpr const char* kThree = R"({ "environment": { "colliders": [ { "plane": {} } ] },
  "objects": [
    { "name": "box", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } }, "pose": { "position_m": [0, 0.1, 0] },
      "physics": { "behavior": "RIGID", "mass_kg": 1 } },
    { "name": "soft", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } }, "pose": { "position_m": [1, 0.1, 0] },
      "physics": { "behavior": "ELASTIC", "youngs_modulus_pa": 50000, "density_kg_m3": 100 } },
    { "name": "step", "shape": { "box": { "size_m": [0.4, 0.1, 0.4] } }, "pose": { "position_m": [-1, 0.05, 0] },
      "physics": { "behavior": "STATIC" } } ] })";

class Edits : public ::testing::Test {
 protected:
  Scene scene(std::shared_ptr<BuildCache> cache = nullptr) {
    SceneOptions options;
    options.cache = std::move(cache);
    auto built = Scene::load(folder_.write("three.scene.json", kThree), options);
    EXPECT_TRUE(built) << built.error().message;
    return std::move(*built);
  }
  static v1::SceneChange::Edit moved(const Scene& scene, int index, const Eigen::Vector3d& to_m) {
    v1::SceneChange::Edit edit;
    *edit.mutable_after() = scene.file().objects(index);
    edit.set_object(edit.after().name());
    edit.mutable_after()->mutable_pose()->clear_position_m();
    for (const double coordinate : to_m) edit.mutable_after()->mutable_pose()->add_position_m(coordinate);
    return edit;
  }
  static Eigen::Vector3d place(const Scene& scene, const char* name) {
    return scene.world().world_point(scene.find(name)->id, Eigen::Vector3d::Zero());
  }
  static void run(Scene& scene, double seconds) {
    for (int i = 0; i < seconds * 90; ++i) scene.step();
  }
  ScratchFolder folder_;
};

TEST_F(Edits, AMovedObjectIsWhereItWasPutAndKeepsItsId) {
  Scene scene = this->scene();
  run(scene, 1);
  const uint32_t box = scene.find("box")->id, soft = scene.find("soft")->id;
  ASSERT_TRUE(scene.edit(moved(scene, 0, {0.5, 0.1, 2})));
  ASSERT_TRUE(scene.edit(moved(scene, 1, {1, 0.1, 2})));
  EXPECT_EQ(scene.find("box")->id, box);
  EXPECT_EQ(scene.find("soft")->id, soft);
  EXPECT_LT((place(scene, "box") - Eigen::Vector3d(0.5, 0.1, 2)).norm(), 1e-9);
  EXPECT_LT((place(scene, "soft") - Eigen::Vector3d(1, 0.1, 2)).norm(), 1e-6);
  run(scene, 2);
  EXPECT_LT((place(scene, "box") - Eigen::Vector3d(0.5, 0.1, 2)).norm(), 1e-3) << "it rests there";
  EXPECT_LT((place(scene, "soft") - Eigen::Vector3d(1, 0.1, 2)).norm(), 0.01);
}

TEST_F(Edits, MovingWhatCarriesWakesWhatItCarried) {
  Scene scene = this->scene();
  ASSERT_TRUE(scene.edit(moved(scene, 0, {1, 0.301, 0})));  // on the soft one
  run(scene, 3);
  ASSERT_GT(place(scene, "box").y(), 0.25);
  ASSERT_TRUE(scene.edit(moved(scene, 1, {3, 0.1, 0})));
  run(scene, 1);
  EXPECT_NEAR(place(scene, "box").y(), 0.1, 2e-3) << "it fell to the floor";
}

TEST_F(Edits, AStaticObjectIsMovedWithItsCollider) {
  Scene scene = this->scene();
  ASSERT_TRUE(scene.edit(moved(scene, 2, {-3, 0.05, 0})));
  ASSERT_TRUE(scene.edit(moved(scene, 0, {-3, 0.21, 0})));
  run(scene, 1);
  EXPECT_NEAR(place(scene, "box").y(), 0.2, 2e-3) << "on the step";
  ASSERT_TRUE(scene.edit(moved(scene, 0, {-1, 0.21, 0})));
  run(scene, 1);
  EXPECT_NEAR(place(scene, "box").y(), 0.1, 2e-3) << "where the step was is floor";
}

TEST_F(Edits, ObjectsComeAndGo) {
  Scene scene = this->scene();
  (void)scene.take_changes();
  v1::SceneChange::Edit edit = moved(scene, 0, {0, 0.3, 0});
  edit.clear_object();
  edit.mutable_after()->set_name("box 2");
  ASSERT_TRUE(scene.edit(edit));
  ASSERT_NE(scene.find("box 2"), nullptr);
  run(scene, 2);
  EXPECT_NEAR(place(scene, "box 2").y(), 0.3, 5e-3) << "it stands on the first";
  v1::SceneChange::Edit removal;
  removal.set_object("box");
  ASSERT_TRUE(scene.edit(removal));
  EXPECT_EQ(scene.find("box"), nullptr);
  run(scene, 1);
  EXPECT_NEAR(place(scene, "box 2").y(), 0.1, 2e-3);
  const Scene::Changes changes = scene.take_changes();
  EXPECT_EQ(changes.added.size(), 1u);
  EXPECT_EQ(changes.removed.size(), 1u);
  EXPECT_FALSE(scene.edit(removal)) << "it is gone";
}

TEST_F(Edits, AnotherMaterialBuildsTheObjectAgain) {
  Scene scene = this->scene();
  run(scene, 0.5);
  const double before_kg = scene.find("box")->mass_kg;
  v1::SceneChange::Edit edit = moved(scene, 0, {0, 0.1, 0});
  edit.mutable_after()->mutable_physics()->clear_mass_kg();
  edit.mutable_after()->set_label("concrete block");
  ASSERT_TRUE(scene.edit(edit));
  EXPECT_GT(scene.find("box")->mass_kg, 5 * before_kg) << "8 l of concrete";
  EXPECT_EQ(scene.find("box")->label, "concrete block");
}

TEST_F(Edits, ACarriedObjectPushesWhatItMeets) {
  Scene scene = this->scene();
  run(scene, 1);
  v1::SceneChange::Carry carry;
  carry.set_object("box");
  const Eigen::Vector3d soft_before = place(scene, "soft");
  for (int i = 0; i < 90; ++i) {  // 1.2 m in a second, through the soft block
    carry.mutable_pose()->clear_position_m();
    for (const double coordinate : {1.2 * i / 90.0, 0.1, 0.0})
      carry.mutable_pose()->add_position_m(coordinate);
    scene.carry(carry);
    scene.step();
  }
  EXPECT_NEAR(place(scene, "box").x(), 1.2, 0.05) << "whatever it met";
  EXPECT_GT(place(scene, "soft").x(), soft_before.x() + 0.15);
  run(scene, 1);  // nobody carries it any more
  EXPECT_NEAR(place(scene, "box").y(), 0.1, 5e-3);
}

TEST_F(Edits, TheCacheGivesTheSameBits) {
  const auto cache = std::make_shared<BuildCache>();
  Scene first = scene(cache), second = scene(cache), fresh = scene();
  for (Scene* one : {&first, &second, &fresh}) {
    ASSERT_TRUE(one->edit(moved(*one, 0, {1, 0.5, 0})));
    run(*one, 2);
  }
  for (const char* name : {"box", "soft"}) {
    EXPECT_EQ(place(first, name), place(second, name)) << name;
    EXPECT_EQ(place(first, name), place(fresh, name)) << name;
  }
}

// A box falls onto the floor that replaces the first one.
TEST_F(Edits, AnotherEnvironmentIsTakenWhileTheSceneRuns) {
  Scene scene = this->scene();
  run(scene, 1);
  const double before = place(scene, "box").y();
  v1::Environment lower = scene.file().environment();
  ASSERT_EQ(lower.colliders_size(), 1);
  for (const double coordinate : {0.0, -0.5, 0.0})
    lower.mutable_colliders(0)->mutable_plane()->add_point_m(coordinate);
  ASSERT_TRUE(scene.replace_environment(lower));
  run(scene, 2);
  EXPECT_NEAR(place(scene, "box").y(), before - 0.5, 5e-3);
  const Scene::Changes changes = scene.take_changes();
  EXPECT_EQ(changes.removed.size(), 1u) << "the drawn floor";
  v1::Environment bad = lower;
  bad.set_asset("none.ply");
  EXPECT_FALSE(scene.replace_environment(bad));
  EXPECT_EQ(scene.file().environment().asset(), "");
}

// The drawn floor reaches under the objects as they are after the edits of the same tick.
TEST_F(Edits, AnEnvironmentIsBuiltAroundTheObjectsAfterTheEditsOfItsTick) {
  const auto floor_end_m = [](Scene& scene) {
    float most = 0;
    for (const uint32_t id : scene.take_changes().added)
      for (const Eigen::Vector3f& at : scene.find(id)->asset->positions) most = std::max(most, at.x());
    return most;
  };
  Scene scene = this->scene();
  v1::Environment lower = scene.file().environment();
  for (const double coordinate : {0.0, -0.5, 0.0})
    lower.mutable_colliders(0)->mutable_plane()->add_point_m(coordinate);
  (void)scene.take_changes();
  ASSERT_TRUE(scene.replace_environment(lower));
  const float alone = floor_end_m(scene);
  v1::SceneChange changes[2];
  *changes[0].mutable_edit() = moved(scene, 0, {3, 0.1, 0});
  changes[1].mutable_edit()->set_object("soft");  // is removed
  ASSERT_TRUE(scene.replace_environment(lower, changes));
  EXPECT_NEAR(floor_end_m(scene), alone + 2, 0.2) << "the soft box ended at 1.1 m, the box ends at 3.1 m";
}

}  // namespace
}  // namespace livegs
