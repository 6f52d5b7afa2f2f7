// SPDX-License-Identifier: Apache-2.0
// The elastic objects of a scene share its time budget and report its effect.
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include "scene/build/elastic_report.h"
#include "scene/build/share_elastic_budget.h"
#include "scene/scene.h"

namespace livegs {
namespace {

constexpr double kBudget = 1.0 / kNodeSubstep_ms;  // node-substeps of a budget of 1 ms

std::string sheet_text(int index, double youngs_modulus_pa) {
  return R"({ "name": "sheet )" + std::to_string(index) +
         R"(", "shape": { "box": { "size_m": [1, 0.004, 1] } }, "spacing_m": 0.01,
      "pose": { "position_m": [0, )" +
         std::to_string(0.5 + 0.2 * index) + R"(, 0] },
      "physics": { "behavior": "ELASTIC", "density_kg_m3": 1000, "youngs_modulus_pa": )" +
         std::to_string(youngs_modulus_pa) + " } }";
}
constexpr const char* kCube = R"({ "name": "cube", "shape": { "box": { "size_m": [0.1, 0.1, 0.1] } },
    "pose": { "position_m": [3, 0.5, 0] },
    "physics": { "behavior": "ELASTIC", "density_kg_m3": 1000, "youngs_modulus_pa": 1e4 } })";

Scene sheets_and_a_cube(int sheets, double youngs_modulus_pa,
                        const std::string& budget = R"("elastic_budget_ms": 1,)") {
  std::string text = R"({ "rate_hz": 60, "substeps": 4, )" + budget + R"( "objects": [ )" + kCube;
  for (int i = 0; i < sheets; ++i) text += ", " + sheet_text(i, youngs_modulus_pa);
  v1::Scene file;
  EXPECT_TRUE(google::protobuf::util::JsonStringToMessage(text + " ] }", &file).ok());
  auto scene = Scene::build(file, "", "sheets", {});
  EXPECT_TRUE(scene) << scene.error().message;
  return std::move(*scene);
}

double node_substeps(const Scene& scene) {
  double sum = 0;
  for (const SceneObject& object : scene.objects()) {
    if (object.elastic) sum += object.elastic->node_substeps;
  }
  return sum;
}

TEST(ElasticBudgetOfAScene, IsSharedAndReported) {
  const Scene one = sheets_and_a_cube(1, 1e6), six = sheets_and_a_cube(6, 1e6);
  const ElasticAccuracy &alone = *one.find("sheet 0")->elastic, &shared = *six.find("sheet 0")->elastic;
  ASSERT_GT(6 * alone.node_substeps, kBudget);
  EXPECT_EQ(alone.unbudgeted_cell_width_m, 0);
  EXPECT_LE(node_substeps(six), kBudget);
  EXPECT_GT(shared.cell_width_m, alone.cell_width_m);
  EXPECT_EQ(shared.unbudgeted_cell_width_m, alone.cell_width_m);
  EXPECT_EQ(shared.unbudgeted_reached_pa, alone.reached_youngs_modulus_pa);
  EXPECT_EQ(six.find("cube")->elastic->cell_width_m, one.find("cube")->elastic->cell_width_m);
  EXPECT_EQ(six.find("cube")->elastic->unbudgeted_cell_width_m, 0);

  std::string warnings;
  for (const std::string& warning : six.find("sheet 0")->all_warnings()) warnings += warning + "\n";
  EXPECT_NE(warnings.find("the elastic budget limits it to cells of"), std::string::npos) << warnings;
  const v1::ElasticAccuracy message = accuracy_message(shared);
  EXPECT_EQ(message.alone_cell_width_m(), alone.cell_width_m);
  EXPECT_EQ(message.node_substeps(), shared.node_substeps);
  EXPECT_EQ(message.alone_reached_youngs_modulus_pa(), shared.unbudgeted_reached_pa);

  const Scene roomy = sheets_and_a_cube(6, 1e6, "");
  EXPECT_EQ(roomy.find("sheet 0")->elastic->cell_width_m, alone.cell_width_m);
  EXPECT_EQ(roomy.find("sheet 0")->elastic->unbudgeted_cell_width_m, 0);
}

Result<Scene> bar_with(const std::string& resolution, const std::string& behavior = "ELASTIC") {
  v1::Scene file;
  const std::string text = R"({ "rate_hz": 90, "substeps": 4, "objects": [ { "name": "bar",
      "shape": { "box": { "size_m": [0.5, 0.02, 0.02] } }, "spacing_m": 0.005, "resolution": )" +
                           resolution + R"(, "physics": { "behavior": ")" + behavior +
                           R"(", "density_kg_m3": 1000, "youngs_modulus_pa": 1e5 } } ] })";
  EXPECT_TRUE(google::protobuf::util::JsonStringToMessage(text, &file).ok());
  return Scene::build(file, "", "bar", {});
}

TEST(ElasticResolutionOfAScene, IsUsedAsGiven) {
  const auto scene = bar_with(R"({ "cell_width_m": 0.01, "substeps": 40 })");
  ASSERT_TRUE(scene) << scene.error().message;
  const ElasticAccuracy& given = *scene->find("bar")->elastic;
  EXPECT_EQ(given.cell_width_m, 0.01);
  EXPECT_EQ(given.substeps, 40);
  EXPECT_FALSE(given.clipped);

  // Too few substeps for the stiffness: used, and the stiffness that they reach is reported.
  const auto slow = bar_with(R"({ "cell_width_m": 0.005, "substeps": 4 })");
  ASSERT_TRUE(slow) << slow.error().message;
  EXPECT_EQ(slow->find("bar")->elastic->substeps, 4);
  EXPECT_TRUE(slow->find("bar")->elastic->clipped);
  std::string warnings;
  for (const std::string& warning : slow->find("bar")->all_warnings()) warnings += warning + "\n";
  EXPECT_NE(warnings.find("stiffness is clipped from 1e+05"), std::string::npos) << warnings;

  const auto rich = bar_with(R"({ "budget_ms": 20 })"), poor = bar_with(R"({ "budget_ms": 0.001 })");
  ASSERT_TRUE(rich && poor);
  EXPECT_LT(poor->find("bar")->elastic->node_substeps, rich->find("bar")->elastic->node_substeps);
}

TEST(ElasticResolutionOfAScene, IsRefusedWhereItCannotBeUsed) {
  const struct {
    const char *resolution, *behavior, *message;
  } cases[] = {
      {R"({ "cell_width_m": 0.002 })", "ELASTIC",
       "resolution.cell_width_m: 0.002 m is less than half of the particles'"},
      {R"({ "cell_width_m": -1 })", "ELASTIC", "resolution.cell_width_m"},
      {R"({ "substeps": 6 })", "ELASTIC", "resolution.substeps: 6 is not a multiple of the scene's 4"},
      {R"({ "substeps": 5000 })", "ELASTIC", "resolution.substeps"},
      {R"({ "cell_width_m": 0.01, "budget_ms": 1 })", "ELASTIC",
       "resolution.budget_ms: conflicts with cell_width_m"},
      {R"({ "substeps": 8 })", "RIGID", "resolution: is only for elastic objects"},
  };
  for (const auto& one : cases) {
    const auto scene = bar_with(one.resolution, one.behavior);
    ASSERT_FALSE(scene) << one.resolution;
    EXPECT_NE(scene.error().message.find(one.message), std::string::npos) << scene.error().message;
  }
}

// An edit of the stiffness keeps the cells. The substeps stay within the remaining budget, and the object
// reports it.
TEST(ElasticBudgetOfAScene, EditsStayWithinTheRemainingBudget) {
  Scene scene = sheets_and_a_cube(5, 1e4);
  const SceneObject& sheet = *scene.find("sheet 0");
  const uint32_t id = sheet.id;
  const double width_m = sheet.elastic->cell_width_m;
  ASSERT_EQ(sheet.elastic->unbudgeted_cell_width_m, 0);
  const auto edit = [&](double youngs_modulus_pa) {
    v1::PhysicalParameters physics = scene.find("sheet 0")->physics;
    physics.mutable_youngs_modulus_pa()->set_best(youngs_modulus_pa);
    EXPECT_TRUE(scene.set_physics(id, physics));
    return *scene.find("sheet 0")->elastic;
  };
  const ElasticAccuracy before = *sheet.elastic, stiff = edit(1e9);
  EXPECT_EQ(stiff.cell_width_m, width_m);
  EXPECT_TRUE(stiff.clipped);
  EXPECT_LE(node_substeps(scene), kBudget);
  EXPECT_GT(stiff.substeps, before.substeps);
  EXPECT_LT(stiff.substeps, kMaxBodySubsteps);
  EXPECT_EQ(stiff.unbudgeted_cell_width_m, width_m);
  EXPECT_GT(stiff.unbudgeted_reached_pa, stiff.reached_youngs_modulus_pa);
  const ElasticAccuracy back = edit(1e4);
  EXPECT_EQ(back.substeps, before.substeps);
  EXPECT_EQ(back.unbudgeted_cell_width_m, 0);
}

TEST(ElasticBudgetOfAScene, RefusesABudgetOutOfRange) {
  v1::Scene file;
  file.set_elastic_budget_ms(0);
  const auto scene = Scene::build(file, "", "none", {});
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find("elastic_budget_ms"), std::string::npos) << scene.error().message;
}

}  // namespace
}  // namespace livegs
