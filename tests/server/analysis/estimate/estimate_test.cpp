// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "analysis/estimate.h"
#include "analysis/estimate/object_classes.h"
#include "analysis/knowledge/tables.h"
#include "geometry/surface/shape_mesh.h"

namespace livegs {
namespace {

ObjectFacts facts_of_box(const char* name, const Eigen::Vector3d& size_m) {
  ObjectFacts facts;
  facts.name = name;
  facts.mesh = mesh_facts(box_mesh(size_m));
  facts.scale_known = true;
  return facts;
}

void expect_sound(const v1::PhysicalParameters& p) {
  const std::tuple<const char*, const v1::EstimatedValue*, double, double> values[] = {
      {"mass_kg", &p.mass_kg(), 1e-6, 2e4},
      {"youngs_modulus_pa", &p.youngs_modulus_pa(), 1, 1e12},
      {"poisson_ratio", &p.poisson_ratio(), 0, 0.49},
      {"structure_coefficient", &p.structure_coefficient(), 1e-4, 1},
      {"deformation_resistance", &p.deformation_resistance(), 0, 1},
      {"plasticity", &p.plasticity(), 0, 1},
      {"damping", &p.damping(), 0, 2},
      {"friction", &p.friction(), 0, 2},
      {"restitution", &p.restitution(), 0, 1},
  };
  for (const auto& [name, value, low, high] : values) {
    EXPECT_TRUE(std::isfinite(value->low()) && std::isfinite(value->high())) << name;
    EXPECT_LE(value->low(), value->best()) << name;
    EXPECT_LE(value->best(), value->high()) << name;
    EXPECT_GE(value->low(), low) << name;
    EXPECT_LE(value->high(), high * (1 + 1e-12)) << name;
    EXPECT_FALSE(value->reason().empty()) << name;
    EXPECT_NE(value->source(), v1::EstimatedValue::SOURCE_UNKNOWN) << name;
  }
  EXPECT_NE(p.behavior(), v1::Physics::AUTO);
  EXPECT_GT(p.confidence(), 0);
  EXPECT_LE(p.confidence(), 0.6);  // the upper bound of an offline estimate
}

TEST(EstimateOffline, ShapeMassIsDensityTimesVolume) {
  // Softwood, 500 kg/m3, one litre, given as a volume.
  ObjectFacts facts = facts_of_box("wood block", {0.1, 0.1, 0.1});
  facts.solid = true;
  const auto p = estimate_offline(facts);
  EXPECT_EQ(p.material(), "softwood");
  EXPECT_NEAR(p.mass_kg().best(), 0.5, 1e-9);
  EXPECT_EQ(p.behavior(), v1::Physics::RIGID);
  expect_sound(p);
}

TEST(EstimateOffline, CapturedMassLiesBetweenBothEstimates) {
  // A shell of ABS, 1050 kg/m3, 5 mm wall on six faces of 0.04 m2, combined with the usual mass of such
  // objects.
  const ObjectFacts facts = facts_of_box("brick model", {0.2, 0.2, 0.2});
  const auto p = estimate_offline(facts);
  const ObjectRow& row = *find_object_row("brick model");
  const double walls_kg = 1050 * 0.005 * 6 * 0.04;
  const double usual_kg =
      row.mass_kg * std::pow(0.2 * 0.2 * 0.2 / (row.size_m.best * row.middle_m * row.short_m), 2.0 / 3);
  EXPECT_GT(p.mass_kg().best(), std::min(walls_kg, usual_kg));
  EXPECT_LT(p.mass_kg().best(), std::max(walls_kg, usual_kg));
  EXPECT_EQ(p.fill(), v1::Physics::SHELL);
  expect_sound(p);
}

// A mug-sized cup with a uniform wall of 4 mm.
ObjectFacts facts_of_cup(const char* name) {
  ObjectFacts facts;
  facts.name = name;
  facts.mesh.size_m = facts.mesh.box_m = {0.1, 0.08, 0.08};
  facts.mesh.area_m2 = 0.055;
  facts.mesh.mean_wall_m = 0.004;
  facts.mesh.volume_m3 = 0.5 * 0.055 * 0.004;
  facts.mesh.hull_volume_m3 = 0.0005;
  facts.mesh.solidity = 0.22;
  facts.mesh.openness = 0.8;
  facts.scale_known = true;
  return facts;
}

// Appearance breaks ties: an unnamed green object is more likely a plant, a clear one glass, a brown one
// wood.
TEST(KindLikelihood, AppearanceFavoursMatchingMaterials) {
  struct Look {
    const char* name;
    AppearanceFacts look;
    const char* likelier;  // a class of materials
    double factor;
  };
  const auto look = [](Eigen::Vector3f rgb, float saturation, float opacity) {
    AppearanceFacts facts;
    facts.mean_rgb = rgb;
    facts.saturation = saturation;
    facts.mean_opacity = opacity;
    facts.hue_spread = 0.1f;
    return facts;
  };
  const Look looks[] = {{"green", look({0.2f, 0.5f, 0.2f}, 0.6f, 0.9f), "plant", 3},
                        {"clear", look({0.7f, 0.7f, 0.7f}, 0.05f, 0.2f), "glass", 3},
                        {"brown", look({0.5f, 0.3f, 0.15f}, 0.5f, 0.9f), "wood", 2},
                        {"garish", look({0.9f, 0.1f, 0.8f}, 0.9f, 0.9f), "plastic", 1.5},
                        {"grey", look({0.5f, 0.5f, 0.5f}, 0.02f, 0.9f), "metal", 1.3}};
  ObjectFacts facts = facts_of_box("", {0.2, 0.15, 0.1});
  for (const Look& one : looks) {
    size_t of_class = 0;
    for (const ObjectRow& row : object_table()) {
      facts.appearance = {};
      const double plain = kind_likelihood(row, facts);
      facts.appearance = one.look;
      const double seen = kind_likelihood(row, facts);
      if (material_row(row.material).material_class == one.likelier) {
        EXPECT_NEAR(seen / plain, one.factor, 1e-6) << one.name << ": " << row.label;
        ++of_class;
      } else {
        EXPECT_LT(seen / plain, one.factor + 1e-6) << one.name << ": " << row.label;
      }
    }
    EXPECT_GT(of_class, 3u) << one.name;
  }
  // Separates two classes of the same size and shape.
  facts.appearance = looks[0].look;
  const auto share_of = [&](const char* of) {
    double share = 0;
    for (const ObjectClass& kind : object_classes(facts).kinds) {
      if (material_row(kind.row->material).material_class == of) share += kind.probability;
    }
    return share;
  };
  const double green = share_of("plant");
  facts.appearance = {};
  EXPECT_GT(green, 2 * share_of("plant"));
}

TEST(EstimateOffline, NamedMaterialDecides) {
  const auto mug = estimate_offline(facts_of_cup("mug")), metal = estimate_offline(facts_of_cup("metal mug")),
             plastic = estimate_offline(facts_of_cup("red plastic mug"));
  EXPECT_EQ(material_row(metal.material()).material_class, "metal");
  EXPECT_EQ(material_row(plastic.material()).material_class, "plastic");
  EXPECT_FALSE(metal.fragile());
  EXPECT_TRUE(mug.fragile());
  EXPECT_LT(plastic.mass_kg().best(), metal.mass_kg().best());
  EXPECT_LT(metal.mass_kg().best(), mug.mass_kg().best());
  // Without the material word the class is open, and the range covers all of them.
  EXPECT_LT(mug.mass_kg().low(), plastic.mass_kg().high());
}

TEST(EstimateOffline, AppleIsNotMadeOfMaterialApple) {
  const char* names[] = {"apple", "plastic apple", "toy apple"};
  double before_kg = 1;
  for (const char* name : names) {
    ObjectFacts facts;
    facts.name = name;
    facts.mesh.size_m = facts.mesh.box_m = {0.075, 0.075, 0.072};
    facts.mesh.volume_m3 = 2.4e-4;
    facts.mesh.area_m2 = 0.019;
    facts.mesh.mean_wall_m = 0.025;
    facts.mesh.solidity = 0.98;
    facts.scale_known = true;
    const double mass_kg = estimate_offline(facts).mass_kg().best();
    EXPECT_LT(mass_kg, before_kg) << name;
    before_kg = mass_kg;
  }
}

TEST(EstimateOffline, CompositeObjectListsItsParts) {
  const auto plant = estimate_offline(facts_of_box("potted plant", {0.3, 0.5, 0.3}));
  ASSERT_GE(plant.parts_size(), 2);
  double sum = 0;
  for (const auto& part : plant.parts()) {
    EXPECT_NE(find_material_row(part.material()), nullptr) << part.material();
    sum += part.mass_share();
  }
  EXPECT_NEAR(sum, 1.0, 1e-9);
  EXPECT_EQ(estimate_offline(facts_of_box("brick", {0.2, 0.1, 0.06})).parts_size(), 0);
}

TEST(EstimateOffline, SoftIsElasticAndHardIsRigid) {
  for (const char* name :
       {"pillow", "sponge", "rubber duck", "felt hat", "potted plant", "teddy bear", "jelly", "football"}) {
    EXPECT_EQ(estimate_offline(facts_of_box(name, {0.3, 0.3, 0.2})).behavior(), v1::Physics::ELASTIC) << name;
  }
  for (const char* name :
       {"mug", "guitar", "statue", "hammer", "brick model", "wine glass", "stool", "brick"}) {
    EXPECT_EQ(estimate_offline(facts_of_box(name, {0.3, 0.3, 0.2})).behavior(), v1::Physics::RIGID) << name;
  }
}

TEST(EstimateOffline, BrittleMaterialHasBreakingImpulse) {
  const auto mug = estimate_offline(facts_of_box("mug", {0.1, 0.1, 0.1}));
  EXPECT_TRUE(mug.fragile());
  EXPECT_GT(mug.break_impulse_n_s().best(), 0);
  EXPECT_FALSE(estimate_offline(facts_of_box("pillow", {0.4, 0.1, 0.4})).fragile());
}

// A glazed mug is clay inside; glass looks the same inside.
TEST(EstimateOffline, CutFacesHaveTheColourOfTheMaterial) {
  const auto mug = estimate_offline(facts_of_box("coffee mug", {0.12, 0.095, 0.085}));
  ASSERT_EQ(mug.material(), "stoneware");
  ASSERT_EQ(mug.interior_rgb_size(), 3);
  for (int part = 0; part < 3; ++part)
    EXPECT_EQ(mug.interior_rgb(part), (*material_row("stoneware").inside_rgb)[static_cast<size_t>(part)]);
  EXPECT_GT(mug.interior_rgb(0), mug.interior_rgb(2));  // warm
  EXPECT_EQ(estimate_offline(facts_of_box("beer glass", {0.14, 0.13, 0.09})).interior_rgb_size(), 0);
}

TEST(EstimateOffline, GuessedScaleWidensTheMassRange) {
  ObjectFacts facts = facts_of_box("mug", {0.1, 0.1, 0.1});
  const auto known = estimate_offline(facts);
  facts.scale_known = false;
  const auto guessed = estimate_offline(facts);
  EXPECT_GT(guessed.mass_kg().high() / guessed.mass_kg().low(),
            known.mass_kg().high() / known.mass_kg().low());
  EXPECT_LT(guessed.confidence(), known.confidence());
}

// Any facts give a valid estimate.
TEST(EstimateOffline, AnyFactsGiveAValidEstimate) {
  std::mt19937_64 random(7);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random() >> 11) * 0x1p-53);
  };
  for (int i = 0; i < 3000; ++i) {
    ObjectFacts facts;
    const size_t length = random() % 24;
    for (size_t k = 0; k < length; ++k) facts.name += static_cast<char>(random() % 256);
    if (i % 3 == 0) facts.name += " glass plant";
    facts.mesh.size_m = Eigen::Vector3d::Constant(std::pow(10.0, uniform(-4, 3)));
    facts.mesh.volume_m3 = std::pow(10.0, uniform(-15, 6));
    facts.mesh.area_m2 = std::pow(10.0, uniform(-10, 5));
    facts.mesh.mean_wall_m = 2 * facts.mesh.volume_m3 / facts.mesh.area_m2;
    facts.mesh.openness = uniform(0, 1);
    facts.mesh.solidity = uniform(0, 1);
    facts.appearance.mean_rgb =
        Eigen::Vector3f(static_cast<float>(uniform(0, 1)), static_cast<float>(uniform(0, 1)),
                        static_cast<float>(uniform(0, 1)));
    facts.appearance.saturation = static_cast<float>(uniform(0, 1));
    facts.appearance.mean_opacity = static_cast<float>(uniform(0, 1));
    facts.scale_known = random() % 2;
    expect_sound(estimate_offline(facts));
    if (HasFailure()) break;
  }
}

}  // namespace
}  // namespace livegs
