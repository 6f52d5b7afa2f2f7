// SPDX-License-Identifier: Apache-2.0
#include "analysis/division/part_places.h"

#include <gtest/gtest.h>

#include <functional>

namespace livegs {
namespace {

using Eigen::Vector3d;

// A pot in a box, its soil in another one, and leaves in the rest.
MaterialParts plant_parts() {
  MaterialParts parts;
  for (const auto& [name, share] :
       {std::pair("pot", 0.5), std::pair("soil", 0.3), std::pair("leaves", 0.2)}) {
    v1::MaterialPart& part = *parts.Add();
    part.set_name(name);
    part.set_material("hardwood");
    part.set_mass_share(share);
  }
  for (int i = 0; i < 2; ++i) {
    const Eigen::AlignedBox3d box(Vector3d(0, 0, 0), Vector3d(1, 1.0 / (i + 1), 1));
    set_boxes({&box, 1}, parts[i]);
  }
  return parts;
}

TEST(CheckParts, RefusesOddPartsWithTheFieldAndARemedy) {
  ASSERT_TRUE(check_parts(plant_parts()));
  struct Case {
    std::function<void(MaterialParts&)> spoil;
    const char* message;
  };
  const Case cases[] = {
      {[](MaterialParts& parts) { parts[1].set_name(""); }, "parts[1].name: is empty; give the part a name"},
      {[](MaterialParts& parts) { parts[0].set_name(std::string(81, 'a')); },
       "parts[0].name: has 81 bytes; give at most 80"},
      {[](MaterialParts& parts) { parts[2].set_name("pot"); },
       "parts[2].name: \"pot\" is already that of another part; give another name"},
      {[](MaterialParts& parts) { parts[0].mutable_boxes(0)->set_min_m(1, 2); },
       "parts[0].boxes[0]: min_m is not below max_m; swap them"},
      {[](MaterialParts& parts) { parts[0].mutable_boxes(0)->mutable_max_m()->RemoveLast(); },
       "parts[0].boxes[0].max_m: must be three numbers between -10000 and 10000"},
      {[](MaterialParts& parts) { parts[1].set_material("unobtainium"); },
       "parts[1].material: \"unobtainium\" is not in the table; give a name of materials.csv"},
      {[](MaterialParts& parts) { parts[1].set_mass_share(0.9); },
       "parts: the mass shares sum to 1.6; they must sum to 1"},
  };
  for (const Case& one : cases) {
    MaterialParts parts = plant_parts();
    one.spoil(parts);
    const auto checked = check_parts(parts);
    ASSERT_FALSE(checked) << one.message;
    EXPECT_EQ(checked.error().message, one.message);
  }
}

// Without any box the object is homogeneous. Parts are placed one after the other.
TEST(CheckParts, AcceptsPartsWithoutPlaces) {
  MaterialParts parts = plant_parts();
  parts[0].clear_boxes();
  EXPECT_TRUE(check_parts(parts));
  for (v1::MaterialPart& part : parts) part.clear_boxes();
  EXPECT_TRUE(check_parts(parts));
}

}  // namespace
}  // namespace livegs
