// SPDX-License-Identifier: GPL-3.0-or-later
// Warnings about rigid objects that are too heavy for a lighter one. At 60 Hz and 4 substeps, a load of up to
// 36 000 times its support rests.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <regex>

#include "livegs/v1/recording.pb.h"
#include "scene/scene.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

class MassRatio : public ::testing::Test {
 protected:
  static std::string box(const char* name, double x_m, double mass_kg, const char* behavior = "RIGID") {
    return R"({ "name": ")" + std::string(name) +
           R"(", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } }, "pose": { "position_m": [)" +
           std::to_string(x_m) + R"(, 0.1, 0] }, "physics": { "behavior": ")" + behavior +
           R"(", "mass_kg": )" + std::to_string(mass_kg) + " } }";
  }
  Scene scene(const std::string& objects, const std::string& fields = "") {
    const std::string text = R"({ "rate_hz": 60, "substeps": 4, )" + fields + R"("objects": [ )" + objects +
                             R"( ], "environment": { "colliders": [ { "plane": {} } ] } })";
    auto built = Scene::load(folder_.write("masses.scene.json", text), {});
    EXPECT_TRUE(built) << built.error().message;
    return std::move(*built);
  }
  // The warning about the masses of an object; empty: none.
  static std::string warning(const Scene& scene, const char* name) {
    std::string all;
    for (const std::string& one : scene.find(name)->all_warnings()) {
      if (one.starts_with("physics.mass_kg: ")) all += one;
    }
    return all;
  }
  // The recommended substeps; 0: none are.
  static int recommended_substeps(const std::string& text) {
    static const std::regex kSubsteps("give ([0-9]+) substeps");
    std::smatch found;
    return std::regex_search(text, found, kSubsteps) ? std::atoi(found[1].str().c_str()) : 0;
  }
  static v1::SceneChange::Edit mass_edit(const Scene& scene, int index, const std::string& object,
                                         const std::string& name, double mass_kg) {
    v1::SceneChange::Edit edit;
    edit.set_object(object);
    *edit.mutable_after() = scene.file().objects(index);
    edit.mutable_after()->set_name(name);
    edit.mutable_after()->mutable_physics()->set_mass_kg(mass_kg);
    edit.mutable_after()->mutable_pose()->set_position_m(0, 3);
    return edit;
  }
  // Whether clients get a new description of the object.
  static bool is_announced(Scene& scene, const char* name) {
    const Scene::Changes changes = scene.take_changes();
    const uint32_t id = scene.find(name)->id;
    return std::count(changes.changed.begin(), changes.changed.end(), id) > 0;
  }
  ScratchFolder folder_;
};

TEST_F(MassRatio, RecommendedSubstepsSilenceTheWarning) {
  const std::string objects = box("light", 0, 0.001) + ", " + box("heavy", 1, 100);
  const int substeps = recommended_substeps(warning(scene(objects), "heavy"));
  EXPECT_EQ(substeps, 12);  // 100 000 / (150 s x 60 Hz) is 11.1
  v1::Scene file = scene(objects).file();
  for (const auto& [given, warned] : {std::pair(substeps - 1, true), {substeps, false}}) {
    file.set_substeps(static_cast<uint32_t>(given));
    const auto again = Scene::build(file, folder_ / "", "again", {});
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(!warning(*again, "heavy").empty(), warned) << given;
  }
}

TEST_F(MassRatio, ImpossibleSubstepsAreNotRecommended) {
  const std::string text = warning(scene(box("light", 0, 1e-5) + ", " + box("heavy", 1, 1000)), "heavy");
  EXPECT_EQ(recommended_substeps(text), 0) << text;
  EXPECT_NE(text.find("more similar masses, at most 9216000 times at 1024 substeps"), text.npos) << text;
}

TEST_F(MassRatio, OnlyObjectsThatCanRestOnEachOther) {
  const std::string light = box("light", 0, 0.001), heavy = box("heavy", 1, 100);
  EXPECT_NE(warning(scene(light + ", " + heavy), "heavy"), "");
  EXPECT_EQ(warning(scene(light + ", " + heavy), "light"), "");
  EXPECT_EQ(warning(scene(light + ", " + box("heavy", 1, 100, "STATIC")), "heavy"), "");
  EXPECT_EQ(warning(scene(box("light", 0, 0.001, "STATIC") + ", " + heavy), "heavy"), "");
  EXPECT_EQ(warning(scene(light + ", " + heavy, R"("gravity_m_s2": [0, 0, 0], )"), "heavy"), "");
  const std::string joint =
      R"("joints": [ { "ball": { "object": "light", "other": "heavy", "point_m": [0.5, 0, 0] } } ], )";
  EXPECT_EQ(warning(scene(light + ", " + heavy, joint), "heavy"), "");
  const std::string middle = box("middle", 2, 0.002);
  EXPECT_NE(warning(scene(light + ", " + heavy + ", " + middle, joint), "heavy").find("of middle"),
            std::string::npos)
      << "the lightest one that is not joined";
}

TEST_F(MassRatio, LaterObjectsAreCompared) {
  Scene scene = this->scene(box("first", 0, 100) + ", " + box("second", 1, 100));
  EXPECT_EQ(warning(scene, "first"), "");
  (void)scene.take_changes();
  ASSERT_TRUE(scene.edit(mass_edit(scene, 0, "", "light", 0.001)));
  EXPECT_TRUE(is_announced(scene, "first"));
  EXPECT_NE(warning(scene, "first").find("of light"), std::string::npos) << warning(scene, "first");
  EXPECT_NE(warning(scene, "second"), "");

  ASSERT_TRUE(scene.edit(mass_edit(scene, 1, "second", "second", 1)));
  EXPECT_EQ(warning(scene, "second"), "") << "1000 times";

  v1::PhysicalParameters heavier = scene.find("second")->physics;
  heavier.mutable_mass_kg()->set_best(200);
  ASSERT_TRUE(scene.set_physics(scene.find("second")->id, heavier));
  EXPECT_NE(warning(scene, "second"), "");

  (void)scene.take_changes();
  v1::SceneChange::Edit removal;
  removal.set_object("light");
  ASSERT_TRUE(scene.edit(removal));
  EXPECT_TRUE(is_announced(scene, "first"));
  EXPECT_EQ(warning(scene, "first"), "");
  EXPECT_EQ(warning(scene, "second"), "");
}

}  // namespace
}  // namespace livegs
