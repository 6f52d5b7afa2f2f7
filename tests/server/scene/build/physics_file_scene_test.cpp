// SPDX-License-Identifier: Apache-2.0
// Sources of an object's parameters at load, by priority: scene file, manual edit, model answer, offline
// estimate.
#include <gtest/gtest.h>

#include "analysis/physics_file.h"
#include "core/log.h"
#include "scene/scene.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

using v1::EstimatedValue;

class PhysicsFileSceneTest : public ::testing::Test {
 protected:
  PhysicsFileSceneTest() {
    std::string points = "x,y,z\n";
    for (int i = 0; i < 64; ++i) {
      points += std::to_string(0.02 * (i % 4)) + "," + std::to_string(0.02 * (i / 4 % 4)) + "," +
                std::to_string(0.02 * (i / 16)) + "\n";
    }
    folder.write("sponge.csv", points);
  }
  Result<Scene> load(const std::string& physics) const {
    return Scene::load(
        folder.write("one.scene.json",
                     R"({ "objects": [ { "points": "sponge.csv", "physics": )" + physics + " } ] }"),
        {});
  }
  v1::PhysicalParameters physics(const std::string& written = "{}") const {
    auto scene = load(written);
    EXPECT_TRUE(scene) << scene.error().message;
    return scene ? scene->find("sponge")->physics : v1::PhysicalParameters();
  }

  ScratchFolder folder;
  std::filesystem::path file = folder / "sponge.physics.json";
};

TEST_F(PhysicsFileSceneTest, SourcesOverrideEachOtherByPriority) {
  const v1::PhysicalParameters offline = physics();
  EXPECT_EQ(offline.mass_kg().source(), EstimatedValue::OFFLINE);
  v1::PhysicalParameters analysed = offline;
  for (auto* value :
       {analysed.mutable_mass_kg(), analysed.mutable_friction(), analysed.mutable_plasticity()}) {
    value->set_best(value->best() * 1.1);
    value->set_high(value->best());
    value->set_source(EstimatedValue::MODEL);
  }
  ASSERT_TRUE(apply_analysis(file, analysed, {}));
  EXPECT_EQ(physics().mass_kg().source(), EstimatedValue::MODEL);
  EXPECT_EQ(physics().mass_kg().best(), offline.mass_kg().best() * 1.1);
  EXPECT_EQ(physics().restitution().source(), EstimatedValue::OFFLINE);

  v1::Physics edits;
  edits.set_friction(0.77);
  edits.set_plasticity(0.33);
  ASSERT_TRUE(edit_physics(file, edits));
  const v1::PhysicalParameters all = physics(R"({ "plasticity": 0.2 })");
  EXPECT_EQ(all.mass_kg().source(), EstimatedValue::MODEL);
  EXPECT_EQ(all.friction().source(), EstimatedValue::PERSON);
  EXPECT_EQ(all.friction().best(), 0.77);
  EXPECT_EQ(all.plasticity().source(), EstimatedValue::SCENE);
  EXPECT_EQ(all.plasticity().best(), 0.2);
}

TEST_F(PhysicsFileSceneTest, WarnsOfEditsThatTheSceneOverrides) {
  v1::Physics edits;
  edits.set_friction(0.77);
  edits.set_plasticity(0.33);
  ASSERT_TRUE(edit_physics(file, edits));
  const auto warnings = [&](const std::string& written) {
    auto scene = load(written);
    EXPECT_TRUE(scene);
    std::string all;
    for (const std::string& warning : scene->find("sponge")->warnings) all += warning + "\n";
    return all;
  };
  EXPECT_NE(
      warnings(R"({ "plasticity": 0.2 })").find("sponge.physics.json: the edit of plasticity has no effect"),
      std::string::npos);
  EXPECT_EQ(warnings(R"({ "damping": 0.2 })").find("has no effect"), std::string::npos);
}

TEST_F(PhysicsFileSceneTest, UsesTheNameFromTheSidecar) {
  folder.write("sponge.physics.json", R"({ "name": "steel bolt" })");
  EXPECT_EQ(physics().material(), "carbon steel");
}

// Two sponges from the same file, and a block without a file.
TEST_F(PhysicsFileSceneTest, GivesEachObjectItsOwnSidecar) {
  const auto scene_file = folder.write("two.scene.json", R"({ "objects": [
    { "name": "left", "points": "sponge.csv" }, { "name": "right one", "points": "./sponge.csv" },
    { "name": "block", "shape": { "box": { "size_m": [0.1, 0.1, 0.1] } } } ] })");
  const auto load = [&] {
    auto scene = Scene::load(scene_file, {});
    EXPECT_TRUE(scene) << scene.error().message;
    return std::move(*scene);
  };
  const Scene first = load();
  EXPECT_EQ(first.find("left")->physics_file, folder / "sponge.physics.left.json");
  EXPECT_EQ(first.find("right one")->physics_file, folder / "sponge.physics.right%20one.json");
  EXPECT_EQ(first.find("block")->physics_file, folder / "two.scene.physics.block.json");
  double kg = 0.1;
  for (const char* name : {"left", "right one", "block"}) {
    v1::Physics edits;
    edits.set_mass_kg(kg);
    ASSERT_TRUE(edit_physics(first.find(name)->physics_file, edits));
    kg += 0.1;
  }
  ASSERT_TRUE(undo_physics(first.find("right one")->physics_file));
  const Scene again = load();
  EXPECT_NEAR(again.find("left")->mass_kg, 0.1, 1e-12);
  EXPECT_EQ(again.find("right one")->mass_kg, first.find("right one")->mass_kg);
  EXPECT_NEAR(again.find("block")->mass_kg, 0.3, 1e-12);
  // A single user of the file keeps its own sidecar; a new object uses the file's sidecar.
  folder.write("two.scene.json", R"({ "objects": [ { "name": "left", "points": "sponge.csv" } ] })");
  EXPECT_NEAR(load().find("left")->mass_kg, 0.1, 1e-12);
  folder.write("two.scene.json", R"({ "objects": [ { "name": "middle", "points": "sponge.csv" } ] })");
  EXPECT_EQ(load().find("middle")->physics_file, file);
}

TEST_F(PhysicsFileSceneTest, RefusesABadFileInOneLine) {
  folder.write("sponge.physics.json", R"({ "edits": { "friction": -2 } })");
  const auto scene = load("{}");
  ASSERT_FALSE(scene);
  // The message names the folder and the remedy.
  for (const std::string& word :
       {(folder.path() / "sponge.physics.json").string() + ": edits.friction: is -2",
        std::string("correct it, or delete the file")}) {
    EXPECT_NE(scene.error().message.find(word), std::string::npos) << scene.error().message;
  }
}

}  // namespace
}  // namespace livegs
