// SPDX-License-Identifier: Apache-2.0
#include "viewer/panels/parameter_slider.h"

#include <gtest/gtest.h>

namespace livegs {
namespace {

constexpr SliderParameter kAll[] = {SliderParameter::Mass,       SliderParameter::YoungsModulus,
                                    SliderParameter::Plasticity, SliderParameter::DeformationResistance,
                                    SliderParameter::Friction,   SliderParameter::BreakImpulse};

TEST(SliderParameter, PositionAndValueRoundTrip) {
  for (const SliderParameter field : kAll) {
    double last = -1;
    for (int i = 0; i <= 50; ++i) {
      const double value = slider_value(field, i / 50.0);
      EXPECT_GT(value, last) << parameter_name(field);
      last = value;
      // Three digits of the value: at most half a percent of it, over at least ln(1000) of a slider.
      EXPECT_NEAR(slider_position(field, value), i / 50.0, 1e-3) << parameter_name(field);
    }
    EXPECT_EQ(slider_position(field, 1e300), 1.0);
    EXPECT_EQ(slider_position(field, -1), 0.0);
  }
}

// A decade of modulus has the same width everywhere.
TEST(SliderParameter, ModulusIsLogarithmic) {
  const auto at = [](double value) { return slider_position(SliderParameter::YoungsModulus, value); };
  EXPECT_NEAR(at(1e4) - at(1e3), at(1e9) - at(1e8), 1e-12);
  EXPECT_NEAR(at(1e4) - at(1e3), 1.0 / 9, 1e-12);  // 100 Pa to 100 GPa are nine decades
}

TEST(SliderParameter, EditSetsOnlyItsField) {
  const auto only = [](const v1::Physics& edit, const std::string& name) {
    std::vector<const google::protobuf::FieldDescriptor*> set;
    edit.GetReflection()->ListFields(edit, &set);
    return set.size() == 1 && set[0]->name() == name;
  };
  EXPECT_TRUE(only(edit_of(SliderParameter::Mass, 2), "mass_kg"));
  EXPECT_TRUE(only(edit_of(SliderParameter::YoungsModulus, 2), "youngs_modulus_pa"));
  EXPECT_TRUE(only(edit_of(SliderParameter::DeformationResistance, 0.2), "deformation_resistance"));
  EXPECT_TRUE(only(edit_of(SliderParameter::Plasticity, 0.2), "plasticity"));
  EXPECT_TRUE(only(edit_of(SliderParameter::BreakImpulse, 2), "break_impulse_n_s"));
  EXPECT_TRUE(only(edit_of(SliderParameter::Friction, 0.2), "friction"));
  EXPECT_TRUE(only(edit_of_fragile(false), "fragile"));
  EXPECT_DOUBLE_EQ(edit_of(SliderParameter::Mass, 2).mass_kg(), 2);
}

// E* = s E: an edit sets the displayed modulus.
TEST(SliderParameter, ModulusIsOfWholeBody) {
  v1::PhysicalParameters physics;
  physics.set_material("foam");
  physics.mutable_youngs_modulus_pa()->set_low(1e4);
  physics.mutable_youngs_modulus_pa()->set_best(2e4);
  physics.mutable_youngs_modulus_pa()->set_high(4e4);
  physics.mutable_structure_coefficient()->set_low(0.25);
  physics.mutable_structure_coefficient()->set_best(0.5);
  physics.mutable_structure_coefficient()->set_high(0.75);
  const v1::EstimatedValue shown = shown_value(SliderParameter::YoungsModulus, physics);
  EXPECT_DOUBLE_EQ(shown.low(), 2500);
  EXPECT_DOUBLE_EQ(shown.best(), 10000);
  EXPECT_DOUBLE_EQ(shown.high(), 30000);
  EXPECT_NE(shown.reason().find("20 kPa of foam times 0.5"), std::string::npos) << shown.reason();
}

TEST(SliderParameter, ShowsApplicableParametersOnly) {
  const auto has = [](const v1::PhysicalParameters& physics, SliderParameter field) {
    const auto fields = slider_parameters(physics);
    return std::find(fields.begin(), fields.end(), field) != fields.end();
  };
  v1::PhysicalParameters physics;
  physics.set_behavior(v1::Physics::ELASTIC);
  EXPECT_TRUE(has(physics, SliderParameter::YoungsModulus));
  EXPECT_FALSE(has(physics, SliderParameter::BreakImpulse));
  physics.set_behavior(v1::Physics::RIGID);
  EXPECT_FALSE(has(physics, SliderParameter::YoungsModulus));
  EXPECT_FALSE(has(physics, SliderParameter::BreakImpulse));
  physics.set_fragile(true);
  EXPECT_TRUE(has(physics, SliderParameter::BreakImpulse));
}

}  // namespace
}  // namespace livegs
