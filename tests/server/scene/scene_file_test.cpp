// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "scene/scene.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

// The message a scene text is refused with; empty when it is taken.
std::string refusal(const std::string& text) {
  ScratchFolder folder;
  const auto path = folder.write("a.scene.json", text);
  auto parsed = read_scene_file(path);
  if (!parsed) return parsed.error().message;
  auto scene = Scene::load(path, {});
  return scene ? "" : scene.error().message;
}

constexpr char kBox[] = R"("shape": { "box": { "size_m": [0.1, 0.1, 0.1] } })";

TEST(SceneFile, CommentsAndDefaultsAreAllowed) {
  EXPECT_EQ(
      refusal(std::string("{ // a box\n \"objects\": [ { \"name\": \"a\", ") + kBox + " } ] /* end */ }"),
      "");
  EXPECT_EQ(refusal("{}"), "");
}

// Each refusal names the file and the field.
TEST(SceneFile, RefusalsNameFileAndField) {
  const std::string box = kBox;
  const std::pair<std::string, const char*> cases[] = {
      {"", "not JSON"},
      {"[]", "one JSON object"},
      {"{ \"objects\": [ {", "line 1"},
      {R"({ "gravitation": 9 })", "gravitation"},
      {R"({ "objects": [ { "name": "a", "asset": "x.ply", "colour": 3 } ] })", "colour"},
      {R"({ "gravity_m_s2": [0, -9.81] })", "gravity_m_s2"},
      {R"({ "rate_hz": 0 })", "rate_hz"},
      {R"({ "rate_hz": "fast" })", "rate_hz"},
      {R"({ "substeps": 100000 })", "substeps"},
      {R"({ "objects": [ { "name": "a" } ] })", "objects[0]: has no form"},
      {R"({ "objects": [ { "name": "a", "shape": { "sphere": { "radius_m": -1 } } } ] })",
       "objects[0].shape.sphere.radius_m"},
      {R"({ "objects": [ { "name": "a", )" + box + R"( }, { "name": "a", )" + box + " } ] }",
       "objects[1].name"},
      {R"({ "objects": [ { "name": "a", )" + box + R"(, "up": "north" } ] })", "objects[0].up"},
      {R"({ "objects": [ { "name": "a", )" + box + R"(, "pose": { "orientation": [0,0,0,0] } } ] })",
       "objects[0].pose.orientation"},
      {R"({ "objects": [ { "name": "a", )" + box + R"(, "physics": { "friction": -1 } } ] })",
       "objects[0].physics.friction"},
      {R"({ "objects": [ { "name": "a", )" + box +
           R"(, "physics": { "mass_kg": 1, "density_kg_m3": 1 } } ] })",
       "density_kg_m3"},
      {R"({ "objects": [ { "name": "a", )" + box + R"(, "physics": { "behavior": "GASEOUS" } } ] })",
       "GASEOUS"},
      {R"({ "objects": [ { "name": "a", "asset": "absent.ply" } ] })", "absent.ply"},
      {R"({ "objects": [ { "name": "a", "points": "absent.csv" } ] })", "absent.csv"},
      {R"({ "environment": { "asset": "absent.ply" } })", "absent.ply"},
      {R"({ "environment": { "colliders": [ {} ] } })", "environment.colliders[0]"},
      {R"({ "environment": { "colliders": [ { "plane": { "normal": [0,0,0] } } ] } })", "plane.normal"},
      {R"({ "environment": { "colliders": [ { "mesh": "absent.obj" } ] } })", "absent.obj"},
      {R"({ "events": [ { "time_s": 1, "force": { "object": "nobody", "force_n": [1,0,0], "duration_s": 1 } } ] })",
       "nobody"},
      {R"({ "events": [ { "time_s": 1 } ] })", "events[0]"},
  };
  for (const auto& [text, field] : cases) {
    const std::string message = refusal(text);
    EXPECT_NE(message.find("a.scene.json"), std::string::npos) << text << "\n" << message;
    EXPECT_NE(message.find(field), std::string::npos) << text << "\n" << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

TEST(SceneFile, AnAbsentFileIsNamed) {
  const auto scene = Scene::load("no_such.scene.json", {});
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find("no_such.scene.json"), std::string::npos);
}

}  // namespace
}  // namespace livegs
