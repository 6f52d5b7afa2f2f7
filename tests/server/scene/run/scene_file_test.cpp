// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "scene/scene.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

// Returns the error message for a scene text; empty if it is accepted.
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

// Each error names the file and the field.
TEST(SceneFile, RefusalsNameFileAndField) {
  const std::string box = kBox;
  const std::pair<std::string, const char*> cases[] = {
      {"", "not JSON"},
      {"[]", "one JSON object"},
      {"{\"objects\":" + std::string(400'000, '[') + std::string(400'000, ']') + "}",
       "objects[0]: must be an object"},
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
      {R"({ "objects": [ { "name": "a", )" + box + R"(, "kernel_per_point": true } ] })", "kernel_per_point"},
  };
  for (const auto& [text, field] : cases) {
    const std::string message = refusal(text);
    EXPECT_NE(message.find("a.scene.json"), std::string::npos) << text << "\n" << message;
    EXPECT_NE(message.find(field), std::string::npos) << text << "\n" << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

// Values of a wrong type are found in the text, with their place.
TEST(SceneFile, RefusesWrongTypesWithTheirPlace) {
  const std::pair<const char*, const char*> cases[] = {
      {R"("mass_kg": "NaN")", "mass_kg of \"hat\": must be a number, not \"NaN\""},
      {R"("youngs_modulus_pa": "Infinity")",
       "youngs_modulus_pa of \"hat\": must be a number, not \"Infinity\""},
      {R"("behavior": 9)", "behavior of \"hat\": must be AUTO, STATIC, RIGID or ELASTIC, not 9"},
      {R"("fill": 9)", "fill of \"hat\": must be FILL_UNKNOWN, SOLID, SHELL, OPEN_SHELL or FILLED, not 9"},
  };
  for (const auto& [physics, expected] : cases) {
    const std::string message =
        refusal(std::string(R"({ "objects": [ { "name": "hat", "asset": "absent.ply", )") +
                R"("physics": { )" + physics + " } } ] }");
    EXPECT_TRUE(message.starts_with("a.scene.json: line 1, column ")) << message;
    EXPECT_TRUE(message.ends_with(std::string(": objects[0].physics.") + expected)) << message;
  }
}

// Physically impossible numbers are refused before an asset is opened. The error gives the valid range.
TEST(SceneFile, RefusesImpossiblePhysicsWithItsRange) {
  const struct {
    const char* physics;
    const char* field;
    const char* range;
  } cases[] = {
      {R"("mass_kg": 0)", "mass_kg: is 0", "between 1e-06 and 1e+06"},
      {R"("mass_kg": -2)", "mass_kg: is -2", "between 1e-06 and 1e+06"},
      {R"("density_kg_m3": 0)", "density_kg_m3: is 0", "between 0.1 and 25000"},
      {R"("wall_thickness_m": -1)", "wall_thickness_m: is -1", "between 1e-06 and 10"},
      {R"("youngs_modulus_pa": 0)", "youngs_modulus_pa: is 0", "between 1 and 1e+12"},
      {R"("poisson_ratio": 0.5)", "poisson_ratio: is 0.5", "between 0 and 0.49"},
      {R"("poisson_ratio": -0.1)", "poisson_ratio: is -0.1", "between 0 and 0.49"},
      {R"("structure_coefficient": 1.5)", "structure_coefficient: is 1.5", "between 1e-06 and 1"},
      {R"("deformation_resistance": 1.1)", "deformation_resistance: is 1.1", "between 1e-06 and 1"},
      {R"("plasticity": 1.01)", "plasticity: is 1.01", "between 0 and 1"},
      {R"("damping": 2.1)", "damping: is 2.1", "between 0 and 2"},
      {R"("damping": -0.1)", "damping: is -0.1", "between 0 and 2"},
      {R"("break_impulse_n_s": -1)", "break_impulse_n_s: is -1", "between 1e-06 and 1e+06"},
      {R"("break_impulse_n_s": 0)", "break_impulse_n_s: is 0", "between 1e-06 and 1e+06"},
      {R"("friction": 3)", "friction: is 3", "between 0 and 2"},
      {R"("restitution": 1.2)", "restitution: is 1.2", "between 0 and 1"},
  };
  for (const auto& one : cases) {
    const std::string physics = std::string(R"("physics": { )") + one.physics + " }";
    std::string message =
        refusal(R"({ "objects": [ { "name": "hat", "asset": "absent.ply", )" + physics + " } ] }");
    EXPECT_EQ(message, "a.scene.json: object \"hat\": objects[0].physics." +
                           message.substr(std::min(message.size(), message.find("physics.") + 8)));
    EXPECT_NE(message.find(one.field), std::string::npos) << message;
    EXPECT_NE(message.find(one.range), std::string::npos) << message;
    // The same message for an event.
    message = refusal(std::string(R"({ "objects": [ { "name": "hat", )") + kBox +
                      R"( } ], "events": [ { "time_s": 1, "set_physics": { "object": "hat", )" + physics +
                      " } } ] }");
    EXPECT_NE(message.find(std::string("object \"hat\": events[0].set_physics.physics.") + one.field),
              std::string::npos)
        << message;
  }
}

TEST(SceneFile, ErrorsStayOnOneLine) {
  const std::string message = refusal(std::string(R"({ "objects": [ { "name": "a\nb", )") + kBox +
                                      R"(, "physics": { "friction": -1 } } ] })");
  EXPECT_NE(message.find("object \"a b\""), std::string::npos) << message;
}

TEST(SceneFile, ErrorsNameAMissingFile) {
  const auto scene = Scene::load("no_such.scene.json", {});
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find("no_such.scene.json"), std::string::npos);
}

}  // namespace
}  // namespace livegs
