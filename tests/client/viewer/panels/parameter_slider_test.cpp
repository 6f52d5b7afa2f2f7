// SPDX-License-Identifier: Apache-2.0
#include "viewer/panels/parameter_slider.h"

#include <gtest/gtest.h>

namespace livegs {
namespace {

constexpr SliderParameter kAll[] = {SliderParameter::Mass,       SliderParameter::YoungsModulus,
                                    SliderParameter::Plasticity, SliderParameter::DeformationResistance,
                                    SliderParameter::Friction,   SliderParameter::BreakImpulse};

v1::EstimatedValue estimated(double low, double best, double high) {
  v1::EstimatedValue value;
  value.set_low(low);
  value.set_best(best);
  value.set_high(high);
  return value;
}

TEST(SliderParameter, PositionAndValueRoundTrip) {
  for (const SliderParameter field : kAll) {
    const SliderRange range = slider_range(field, estimated(0.2, 0.3, 0.4));
    double last = -1;
    for (int i = 0; i <= 50; ++i) {
      const double value = slider_value(range, i / 50.0);
      EXPECT_GT(value, last) << parameter_name(field);
      last = value;
      // Three digits of the value: at most half a percent of it, over at least ln(10) of a slider.
      EXPECT_NEAR(slider_position(range, value), i / 50.0, 2.2e-3) << parameter_name(field);
    }
    EXPECT_EQ(slider_position(range, 1e300), 1.0);
    EXPECT_EQ(slider_position(range, -1), 0.0);
  }
}

TEST(SliderParameter, RangeIsTenTimesThePlausible) {
  const SliderRange range = slider_range(SliderParameter::YoungsModulus, estimated(1e4, 3e4, 1e5));
  EXPECT_DOUBLE_EQ(range.low, 1e3);
  EXPECT_DOUBLE_EQ(range.high, 1e6);
  EXPECT_NEAR(slider_position(range, 1e4), 1.0 / 3, 1e-12);
  EXPECT_NEAR(slider_position(range, 1e5), 2.0 / 3, 1e-12);
  // A value that was set by hand has no range of its own, and one beyond the field's limits stays in reach.
  const SliderRange by_hand = slider_range(SliderParameter::Mass, estimated(2, 2, 2));
  EXPECT_DOUBLE_EQ(by_hand.low, 0.2);
  EXPECT_DOUBLE_EQ(by_hand.high, 20);
  const SliderRange heavy = slider_range(SliderParameter::Mass, estimated(1e5, 1e5, 1e5));
  EXPECT_LT(heavy.low, heavy.high);
  EXPECT_EQ(slider_position(heavy, 1e5), 1.0);
  const SliderRange share = slider_range(SliderParameter::Plasticity, estimated(0.1, 0.2, 0.3));
  EXPECT_EQ(share.low, 0);
  EXPECT_EQ(share.high, 1);
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
