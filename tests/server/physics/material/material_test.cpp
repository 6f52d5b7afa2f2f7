// SPDX-License-Identifier: Apache-2.0
#include "physics/material.h"

#include <gtest/gtest.h>

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

TEST(Material, StructureCoefficientScalesTheStiffness) {
  Material material;
  material.youngs_modulus_pa = 2e6;
  material.structure_coefficient = 0.25;
  EXPECT_EQ(material.effective_youngs_modulus_pa(), 5e5);
}

}  // namespace
}  // namespace livegs
