// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "analysis/estimate.h"
#include "geometry/surface/shape_mesh.h"

namespace livegs {
namespace {

class MergeScenePhysics : public testing::Test {
 protected:
  MergeScenePhysics() {
    facts.name = "mug";
    facts.mesh = mesh_facts(box_mesh({0.1, 0.1, 0.1}));
    estimated = estimate_offline(facts);
  }
  v1::PhysicalParameters merge() { return merge_scene_physics(estimated, written, facts).value(); }

  ObjectFacts facts;
  v1::PhysicalParameters estimated;
  v1::Physics written;
};

TEST_F(MergeScenePhysics, NoAuthorValueChangesNothing) {
  EXPECT_EQ(merge().SerializeAsString(), estimated.SerializeAsString());
}

TEST_F(MergeScenePhysics, AuthorValuesWinWithAReason) {
  written.set_mass_kg(0.4);
  written.set_friction(0.9);
  const auto merged = merge();
  EXPECT_EQ(merged.mass_kg().best(), 0.4);
  EXPECT_EQ(merged.mass_kg().source(), v1::EstimatedValue::SCENE);
  EXPECT_EQ(merged.friction().best(), 0.9);
  EXPECT_EQ(merged.restitution().source(), v1::EstimatedValue::OFFLINE);
}

TEST_F(MergeScenePhysics, DensityTimesVolumeIsMass) {
  written.set_density_kg_m3(800);
  written.set_fill(v1::Physics::SOLID);
  EXPECT_NEAR(merge().mass_kg().best(), 0.8, 1e-12);
}

TEST_F(MergeScenePhysics, GivenStiffnessIsThatOfTheWholeBody) {
  written.set_youngs_modulus_pa(1e6);
  const auto merged = merge();
  EXPECT_EQ(merged.structure_coefficient().best(), 1.0);
  EXPECT_EQ(merged.behavior(), v1::Physics::ELASTIC);               // AUTO, and a body of 1 MPa deforms
  EXPECT_NEAR(merged.deformation_resistance().best(), 0.5, 1e-12);  // a break point of the paper's map
}

TEST_F(MergeScenePhysics, DeformationResistanceIsConvertedToStiffness) {
  written.set_deformation_resistance(0.8);
  const auto merged = merge();
  EXPECT_NEAR(merged.youngs_modulus_pa().best(), 50e6, 1);  // the next break point
  EXPECT_NEAR(merged.deformation_resistance().best(), 0.8, 1e-9);
}

TEST_F(MergeScenePhysics, ContradictionsAndRangeErrorsNameTheField) {
  const std::pair<void (*)(v1::Physics&), const char*> cases[] = {
      {[](v1::Physics& p) { p.set_mass_kg(-1); }, "mass_kg"},
      {[](v1::Physics& p) { p.set_mass_kg(std::nan("")); }, "mass_kg"},
      {[](v1::Physics& p) { p.set_poisson_ratio(0.5); }, "poisson_ratio"},
      {[](v1::Physics& p) { p.set_restitution(1.5); }, "restitution"},
      {[](v1::Physics& p) { p.set_youngs_modulus_pa(1e300); }, "youngs_modulus_pa"},
      {[](v1::Physics& p) { p.set_mass_kg(1), p.set_density_kg_m3(1); }, "density_kg_m3"},
      {[](v1::Physics& p) { p.set_youngs_modulus_pa(1e5), p.set_deformation_resistance(0.1); },
       "deformation_resistance"},
  };
  for (const auto& [write, field] : cases) {
    v1::Physics physics;
    write(physics);
    const auto merged = merge_scene_physics(estimated, physics, facts);
    ASSERT_FALSE(merged) << field;
    EXPECT_EQ(merged.error().message.find(field), 0u) << merged.error().message;
  }
}

TEST(ToMaterial, ConvertsEveryValueToSi) {
  v1::PhysicalParameters p;
  p.set_behavior(v1::Physics::ELASTIC);
  p.set_fill(v1::Physics::OPEN_SHELL);
  p.mutable_mass_kg()->set_best(0.25);
  p.mutable_youngs_modulus_pa()->set_best(2e6);
  p.mutable_structure_coefficient()->set_best(0.1);
  p.mutable_poisson_ratio()->set_best(0.45);
  const Material material = to_material(p);
  EXPECT_EQ(material.behavior, Behavior::Elastic);
  EXPECT_EQ(material.fill, Fill::OpenShell);
  EXPECT_EQ(material.mass_kg, 0.25);
  EXPECT_DOUBLE_EQ(material.effective_youngs_modulus_pa(), 2e5);
  EXPECT_EQ(material.poisson_ratio, 0.45);
}

}  // namespace
}  // namespace livegs
