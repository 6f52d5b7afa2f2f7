// SPDX-License-Identifier: Apache-2.0
#include "physics/material.h"

#include <gtest/gtest.h>

#include <cmath>

namespace livegs {
namespace {

TEST(DeformationResistance, MatchesThePapersTableAtBreakPoints) {
  EXPECT_EQ(deformation_resistance(0.0), 0.0);
  EXPECT_EQ(deformation_resistance(1e5), 0.1);
  EXPECT_EQ(deformation_resistance(1e6), 0.5);
  EXPECT_EQ(deformation_resistance(5e7), 0.8);
  EXPECT_EQ(deformation_resistance(2e8), 1.0);
}

TEST(DeformationResistance, IsLinearBetweenBreakPointsAndFlatBeyond) {
  EXPECT_DOUBLE_EQ(deformation_resistance(5e4), 0.05);
  EXPECT_DOUBLE_EQ(deformation_resistance(5.5e5), 0.3);
  EXPECT_EQ(deformation_resistance(1e12), 1.0);
  EXPECT_EQ(deformation_resistance(-1.0), 0.0);
}

TEST(DeformationResistance, InverseIsExactAtBreakPoints) {
  for (const double stiffness : {0.0, 1e5, 1e6, 5e7, 2e8}) {
    EXPECT_EQ(effective_youngs_modulus_pa(deformation_resistance(stiffness)), stiffness);
  }
  for (const double stiffness : {3e3, 2e5, 7e6, 1.1e8}) {
    // Rounding of the fraction is amplified by the slope, at most 2e8 Pa per unit of resistance.
    EXPECT_NEAR(effective_youngs_modulus_pa(deformation_resistance(stiffness)), stiffness, 1e-6);
  }
}

TEST(ResistanceBlend, MatchesThePaperAtItsSubstep) {
  for (const double resistance : {0.0, 1e-6, 0.1, 0.37, 0.5, 0.8, 0.999999, 1.0}) {
    // Two divisions and three products: a few roundings.
    EXPECT_NEAR(resistance_blend(resistance_stiffness_per_s2(resistance), kPaperSubstep_s), resistance,
                1e-15);
  }
}

TEST(ResistanceBlend, EqualsTheImplicitStepOfASpring) {
  // omega² = 0.5 / 0.5 * 240² = 57600; at half the substep 57600 / 480² = 1/4, so 0.25 / 1.25.
  EXPECT_DOUBLE_EQ(resistance_stiffness_per_s2(0.5), 57600.0);
  EXPECT_DOUBLE_EQ(resistance_blend(57600.0, 1.0 / 480.0), 0.2);
  EXPECT_DOUBLE_EQ(resistance_blend(57600.0, 1.0 / 60.0), 16.0 / 17.0);
  EXPECT_EQ(resistance_blend(0.0, 1.0), 0.0);
  // A short step covers a fraction omega² h² of the distance; the rest of the series is its square.
  EXPECT_NEAR(resistance_blend(57600.0, 1e-6) / 57600e-12, 1.0, 1e-7);
}

TEST(ResistanceBlend, RigidIsRigidAtAnyStep) {
  EXPECT_TRUE(std::isinf(resistance_stiffness_per_s2(1.0)));
  EXPECT_TRUE(std::isinf(resistance_stiffness_per_s2(7.0)));
  EXPECT_EQ(resistance_stiffness_per_s2(-1.0), 0.0);
  for (const double step_s : {1e-300, 1e-6, 1.0 / 240.0, 1.0, 1e200}) {
    EXPECT_EQ(resistance_blend(resistance_stiffness_per_s2(1.0), step_s), 1.0);
  }
}

TEST(Material, StructureCoefficientScalesTheStiffness) {
  Material material;
  material.youngs_modulus_pa = 2e6;
  material.structure_coefficient = 0.25;
  EXPECT_EQ(material.effective_youngs_modulus_pa(), 5e5);
}

}  // namespace
}  // namespace livegs
