// SPDX-License-Identifier: Apache-2.0
// Reports about an elastic object, and replacement by a rigid body if its stiffness is out of reach.
#include "scene/build/elastic_report.h"

#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <cmath>

#include "scene/scene.h"

namespace livegs {
namespace {

Scene one_object(const std::string& object) {
  v1::Scene file;
  const auto parsed = google::protobuf::util::JsonStringToMessage(
      R"({ "rate_hz": 60, "substeps": 4, "objects": [ )" + object + " ] }", &file);
  EXPECT_TRUE(parsed.ok()) << parsed.message();
  auto scene = Scene::build(file, "", "one", {});
  EXPECT_TRUE(scene) << scene.error().message;
  return std::move(*scene);
}

// A cube of this edge length and stiffness; `said` is its behavior.
Scene cube(const char* name, double edge_m, double youngs_modulus_pa, const char* said) {
  char object[400];
  std::snprintf(object, sizeof object,
                R"({ "name": "%s", "shape": { "box": { "size_m": [%g, %g, %g] } },
                     "physics": { "behavior": "%s", "density_kg_m3": 1000, "youngs_modulus_pa": %g } })",
                name, edge_m, edge_m, edge_m, said, youngs_modulus_pa);
  return one_object(object);
}

TEST(ElasticReport, ObjectMessageAndLineAgree) {
  const Scene scene = cube("cube", 0.2, 2e4, "ELASTIC");
  const SceneObject& object = scene.objects()[0];
  ASSERT_TRUE(object.elastic);
  const ElasticAccuracy accuracy = scene.world().elastic_body(object.id)->accuracy();
  const v1::ElasticAccuracy message = accuracy_message(*object.elastic);
  EXPECT_EQ(message.cell_width_m(), accuracy.cell_width_m);
  EXPECT_EQ(message.substeps(), static_cast<uint32_t>(accuracy.substeps));
  EXPECT_EQ(message.courant(), accuracy.courant);
  EXPECT_EQ(message.youngs_modulus_pa(), 2e4);
  EXPECT_EQ(message.reached_youngs_modulus_pa(), accuracy.reached_youngs_modulus_pa);
  EXPECT_EQ(message.modulus_ratio_low(), accuracy.modulus_ratio_low);
  EXPECT_EQ(message.modulus_ratio_high(), accuracy.modulus_ratio_high);
  EXPECT_EQ(message.modulus_ratio_across(), accuracy.modulus_ratio_across);
  EXPECT_EQ(message.nodes(), accuracy.nodes);
  EXPECT_EQ(message.bytes(), accuracy.bytes);
  // sqrt(E / rho) h / a
  EXPECT_NEAR(message.courant(), std::sqrt(2e4 / 1000) / (60 * accuracy.substeps * accuracy.cell_width_m),
              1e-9);
  EXPECT_EQ(accuracy_line(accuracy).find("E 2e+04 Pa "), 0u) << accuracy_line(accuracy);
}

// A typical mistake, 500 mm for 5: one particle in place of a cube.
TEST(ElasticReport, WarnsOfSpacingTooWideForTheShape) {
  const auto spaced = [](const char* spacing_m) {
    const Scene scene =
        one_object(std::string(R"({ "name": "cube", "shape": { "box": { "size_m": [0.1, 0.1, 0.1] } },
        "physics": { "behavior": "ELASTIC", "density_kg_m3": 1000, "youngs_modulus_pa": 1e5 }, "spacing_m": )") +
                   spacing_m + " }");
    std::string all;
    for (const std::string& warning : scene.objects()[0].all_warnings()) all += warning + "\n";
    return all;
  };
  EXPECT_EQ(spaced("0.025").find("spacing_m"), std::string::npos) << spaced("0.025");
  EXPECT_EQ(spaced("0.5").find(
                "spacing_m: 0.5 m is more than a quarter of the longest side, which leaves only 1 particles"),
            0u)
      << spaced("0.5");
}

TEST(ElasticReport, WarnsOfResetsThinPartsAndBudget) {
  ElasticAccuracy accuracy;
  accuracy.cell_width_m = 0.1;
  EXPECT_TRUE(accuracy_warnings(accuracy).empty());
  accuracy.recovery_count = 2;
  accuracy.thin_part = 0.5;
  accuracy.over_budget = true;
  accuracy.sag = 1.0;
  accuracy.youngs_modulus_pa = 3e3;
  const auto warnings = accuracy_warnings(accuracy);
  ASSERT_EQ(warnings.size(), 4u);
  EXPECT_EQ(warnings[1].find("too thin and wide for the time budget"), 0u) << warnings[1];
  EXPECT_NE(warnings[2].find("strain 1, inner points may sink through the support; raise "
                             "youngs_modulus_pa to 3e+04 "),
            std::string::npos)
      << warnings[2];
  EXPECT_EQ(warnings[0].find("50 % of the volume is sheets or cords thinner than half a cell of 100 mm"), 0u)
      << warnings[0];
  EXPECT_NE(warnings[3].find("simulation diverged: reset to the rest shape 2 times"), std::string::npos)
      << warnings[3];
}

TEST(ElasticReport, WarnsOfAClippedStiffness) {
  const Scene scene = cube("cube", 0.1, 1e9, "ELASTIC");
  const SceneObject& object = scene.objects()[0];
  ASSERT_TRUE(object.elastic);
  EXPECT_EQ(accuracy_message(*object.elastic).band(), v1::ElasticAccuracy::CLIPPED);
  EXPECT_LT(object.elastic->reached_youngs_modulus_pa, 1e8);
  const auto warnings = object.all_warnings();
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].find("stiffness is clipped from 1e+09 to "), 0u) << warnings[0];
}

// Cells and substeps are chosen for the stiffest material of the body. Clipping is reported for that material
// only.
TEST(ElasticReport, ClipsTheStiffFootOnly) {
  const Scene scene = one_object(R"({ "name": "cube", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } },
      "physics": { "behavior": "ELASTIC", "density_kg_m3": 1000, "youngs_modulus_pa": 2e4 },
      "regions": [ { "name": "foot", "box": { "min_m": [-0.1, -0.1, -0.1], "max_m": [0.1, -0.05, 0.1] },
                     "material": { "youngs_modulus_pa": 1e9 } } ] })");
  const SceneObject& object = scene.objects()[0];
  ASSERT_TRUE(object.elastic);
  const ElasticAccuracy& accuracy = *object.elastic;
  EXPECT_FALSE(accuracy.clipped);
  EXPECT_EQ(accuracy.band, ElasticBand::Exact);
  EXPECT_EQ(accuracy.youngs_modulus_pa, 2e4);
  EXPECT_EQ(accuracy.reached_youngs_modulus_pa, 2e4);
  ASSERT_EQ(accuracy.regions.size(), 1u);
  const RegionAccuracy& foot = accuracy.regions[0];
  EXPECT_EQ(foot.name, "foot");
  EXPECT_TRUE(foot.clipped);
  EXPECT_EQ(foot.band, ElasticBand::Clipped);
  EXPECT_EQ(foot.youngs_modulus_pa, 1e9);
  // sqrt(E / rho) h / a is the reported Courant number.
  const double wave_m_s = accuracy.courant * 60 * accuracy.substeps * accuracy.cell_width_m;
  EXPECT_NEAR(foot.reached_youngs_modulus_pa / (1000 * wave_m_s * wave_m_s), 1.0, 1e-9);
  // With few cells along the foot, the upper end of the band is wider.
  EXPECT_GE(foot.modulus_ratio_high * 1e9, foot.reached_youngs_modulus_pa);
  EXPECT_LE(foot.modulus_ratio_high * 1e9, 2.0 * foot.reached_youngs_modulus_pa);
  const auto warnings = object.all_warnings();
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].find("foot: stiffness is clipped from 1e+09 to "), 0u) << warnings[0];
  EXPECT_NE(accuracy_line(accuracy).find("; in foot E 1e+09 Pa clipped to "), std::string::npos)
      << accuracy_line(accuracy);
  // The reverse case: a soft part of a stiff body.
  const Scene soft = one_object(R"({ "name": "cube", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } },
      "physics": { "behavior": "ELASTIC", "density_kg_m3": 1000, "youngs_modulus_pa": 1e9 },
      "regions": [ { "box": { "min_m": [-0.1, -0.1, -0.1], "max_m": [0.1, -0.05, 0.1] },
                     "material": { "youngs_modulus_pa": 2e4 } } ] })");
  const ElasticAccuracy& stiff = *soft.objects()[0].elastic;
  EXPECT_TRUE(stiff.clipped);
  EXPECT_FALSE(stiff.regions.at(0).clipped);
  EXPECT_EQ(stiff.regions.at(0).reached_youngs_modulus_pa, 2e4);
}

// 100 MPa is below the limit above which the paper treats all objects as rigid. A 50 mm cube at 60 Hz reaches
// a fiftieth of it: one cell across in 32 substeps has rho (Co rate n a)^2 = 1000 (0.5 * 60 * 32 * 0.05)^2 =
// 2.3 MPa.
TEST(ElasticReport, BuildsFarTooStiffAutoObjectsAsRigid) {
  const Scene rigid = cube("cube", 0.05, 1e8, "AUTO");
  const SceneObject& object = rigid.objects()[0];
  EXPECT_EQ(object.physics.behavior(), v1::Physics::RIGID);
  EXPECT_EQ(rigid.world().elastic_body(object.id), nullptr);
  EXPECT_FALSE(object.elastic);
  EXPECT_EQ(object.physics.behavior_reason().find("E* = 1e+08 Pa is "), 0u)
      << object.physics.behavior_reason();
  EXPECT_EQ(object.all_warnings(), std::vector<std::string>{object.physics.behavior_reason()});
  EXPECT_NEAR(object.mass_kg, 0.125, 1e-9);

  const Scene elastic = cube("cube", 0.05, 1e8, "ELASTIC");
  EXPECT_NE(elastic.world().elastic_body(elastic.objects()[0].id), nullptr);
  // At twenty times the size the reachable stiffness is four hundred times higher.
  const Scene large = cube("cube", 1.0, 1e8, "AUTO");
  EXPECT_NE(large.world().elastic_body(large.objects()[0].id), nullptr);
}

// The value is used as written, and the warning names the expected range.
TEST(ElasticReport, WarnsOfAStiffPillow) {
  const Scene scene = cube("pillow", 0.3, 2e9, "ELASTIC");
  const SceneObject& object = scene.objects()[0];
  const auto warnings = object.all_warnings();
  ASSERT_FALSE(warnings.empty());
  EXPECT_EQ(warnings[0].find("physics.youngs_modulus_pa: 2e+09 Pa is used as written, but a pillow of "), 0u)
      << warnings[0];
  EXPECT_NE(warnings[0].find(" to "), std::string::npos) << warnings[0];
  EXPECT_EQ(object.elastic->youngs_modulus_pa, 2e9);
  for (const std::string& warning : cube("pillow", 0.3, 2e4, "ELASTIC").objects()[0].all_warnings()) {
    EXPECT_EQ(warning.find("physics.youngs_modulus_pa"), std::string::npos) << warning;
  }
}

// A shape is solid whatever its palette colour: 500 kg/m3 times one litre.
TEST(ElasticReport, ShapesAreSolidByDefault) {
  v1::Scene file;
  for (int i = 0; i < 6; ++i) {
    v1::Object& object = *file.add_objects();
    object.set_name("thing " + std::to_string(i));
    for (int d = 0; d < 3; ++d) object.mutable_shape()->mutable_box()->add_size_m(0.1);
    object.mutable_physics()->set_behavior(v1::Physics::RIGID);
    object.mutable_physics()->set_density_kg_m3(500);
  }
  file.mutable_objects(5)->mutable_physics()->set_fill(v1::Physics::SHELL);
  file.mutable_objects(5)->mutable_physics()->set_wall_thickness_m(0.001);
  auto scene = Scene::build(file, "", "things", {});
  ASSERT_TRUE(scene) << scene.error().message;
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(scene->objects()[i].mass_kg, 0.5, 1e-12) << i;
  EXPECT_NEAR(scene->objects()[5].mass_kg, 500 * 0.001 * 0.06, 1e-12);  // wall times area
}

}  // namespace
}  // namespace livegs
