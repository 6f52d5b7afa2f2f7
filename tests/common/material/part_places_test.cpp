// SPDX-License-Identifier: Apache-2.0
#include "material/part_places.h"

#include <gtest/gtest.h>

namespace livegs {
namespace {

v1::MaterialPart::Box* add_box(v1::MaterialPart& part, const Eigen::Vector3d& low,
                               const Eigen::Vector3d& high) {
  v1::MaterialPart::Box* box = part.add_boxes();
  box->mutable_min_m()->Add(low.data(), low.data() + 3);
  box->mutable_max_m()->Add(high.data(), high.data() + 3);
  return box;
}

// A shaft within a head: the later box applies where both are.
TEST(PartPlaces, LaterBoxAppliesAndTheFirstPartWithoutBoxesIsTheRest) {
  MaterialParts parts;
  add_box(*parts.Add(), {-1, -1, -1}, {1, 1, 1});
  parts.Add();
  add_box(*parts.Add(), {-0.2, -5, -0.2}, {0.2, 5, 0.2});
  parts.Add();
  const PartPlaces places(parts);
  EXPECT_EQ(places.at({0.9, 0, 0}), 0u);
  EXPECT_EQ(places.at({0, 0, 0}), 2u);
  EXPECT_EQ(places.at({0, 4, 0}), 2u);
  EXPECT_EQ(places.at({3, 0, 0}), 1u);
}

TEST(PartPlaces, WithoutAPartWithoutBoxesTheFirstIsTheRest) {
  MaterialParts parts;
  EXPECT_FALSE(PartPlaces(parts).divided());
  add_box(*parts.Add(), {0, 0, 0}, {1, 1, 1});
  add_box(*parts.Add(), {1, 0, 0}, {2, 1, 1})->clear_max_m();  // open above
  const PartPlaces places(parts);
  EXPECT_EQ(places.at({-5, 0, 0}), 0u);
  EXPECT_EQ(places.at({500, 20, 3}), 1u);
}

TEST(PartPlaces, AreEqualIfAllBoxesAreEqual) {
  MaterialParts parts;
  add_box(*parts.Add(), {0, 0, 0}, {1, 1, 1});
  add_box(*parts.Add(), {1, 0, 0}, {2, 1, 1})->clear_max_m();
  const PartPlaces before(parts);
  parts[0].set_density_kg_m3(900);
  EXPECT_TRUE(before == PartPlaces(parts));
  parts[0].mutable_boxes(0)->set_max_m(1, 1.5);
  EXPECT_FALSE(before == PartPlaces(parts));
}

// Brightness changes the shade of a part by a factor, so its hue stays that of the legend.
TEST(PartColour, ShadeKeepsTheHueAndPartsStayDistinct) {
  for (size_t i = 0; i < kMaxMaterialParts; ++i) {
    const Eigen::Vector3f dark = shaded_part_rgb(i, {0, 0, 0}), bright = shaded_part_rgb(i, {1, 1, 1});
    EXPECT_TRUE(bright.isApprox(part_rgb(i)));
    EXPECT_TRUE((2 * dark).isApprox(bright));
    for (size_t k = 0; k < i; ++k)
      EXPECT_GT((part_rgb(i) - part_rgb(k)).norm(), 0.25f) << "parts " << i << " and " << k;
  }
}

}  // namespace
}  // namespace livegs
