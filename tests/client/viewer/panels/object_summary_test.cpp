// SPDX-License-Identifier: Apache-2.0
#include "viewer/panels/object_summary.h"

#include <gtest/gtest.h>

namespace livegs {
namespace {

TEST(ObjectLine, ShowsAccuracyOfElasticStiffness) {
  StreamedObject object;
  object.name = "hat";
  object.mass_kg = 0.09;
  v1::ElasticAccuracy& elastic = object.elastic.emplace();
  elastic.set_youngs_modulus_pa(9e5);
  elastic.set_reached_youngs_modulus_pa(4e5);
  elastic.set_band(v1::ElasticAccuracy::CLIPPED);
  elastic.set_modulus_ratio_low(0.42);
  elastic.set_modulus_ratio_high(0.48);
  elastic.set_cell_width_m(0.05);
  elastic.set_substeps(28);
  elastic.set_courant(0.75);
  elastic.set_nodes(183);
  elastic.set_bytes(52000);
  EXPECT_EQ(
      object_summary(object),
      "hat: elastic, 0.09 kg, E 9e+05 Pa clipped to 4e+05 Pa (simulated at 0.42 to 0.48 times E); cells "
      "50 mm, 28 substeps, Courant 0.75, 183 nodes, 52 kB");
  elastic.set_modulus_ratio_across(0.6);
  EXPECT_NE(
      object_summary(object).find("(simulated at 0.42 to 0.48 times E; across its shortest side up to 0.6)"),
      std::string::npos);
  // The ratio is omitted if it is unknown.
  elastic.set_band(v1::ElasticAccuracy::UNKNOWN);
  elastic.clear_modulus_ratio_low();
  elastic.clear_modulus_ratio_high();
  EXPECT_NE(object_summary(object).find("Pa unknown; cells"), std::string::npos) << object_summary(object);
}

TEST(ObjectLine, OmitsStiffnessOfRigidObjects) {
  StreamedObject object;
  object.name = "cup";
  object.mass_kg = 0.266;
  EXPECT_EQ(object_summary(object), "cup: rigid, 0.266 kg");
  object.mass_kg = 0;
  EXPECT_EQ(object_summary(object), "cup: static");
}

}  // namespace
}  // namespace livegs
