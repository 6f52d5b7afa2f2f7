// SPDX-License-Identifier: Apache-2.0
#include "viewer/panels/part_list.h"

#include <gtest/gtest.h>

#include <numeric>

namespace livegs {
namespace {

const Eigen::AlignedBox3d kBody{Eigen::Vector3d(-0.1, 0.0, -0.2), Eigen::Vector3d(0.1, 0.4, 0.2)};

// Head, handle and grip with shares of 0.5, 0.3 and 0.2; the head is in a box.
PartList hammer() {
  MaterialParts parts;
  for (const auto& [name, share] :
       {std::pair("head", 0.5), std::pair("handle", 0.3), std::pair("grip", 0.2)}) {
    v1::MaterialPart& part = *parts.Add();
    part.set_name(name);
    part.set_material("hardwood");
    part.set_mass_share(share);
    part.set_density_kg_m3(700);
  }
  parts[0].add_boxes();  // open on all sides
  return PartList(parts);
}

std::vector<double> shares(const PartList& list) {
  std::vector<double> all;
  for (const v1::MaterialPart& part : list.parts()) all.push_back(part.mass_share());
  EXPECT_NEAR(std::accumulate(all.begin(), all.end(), 0.0), 1.0, 1e-12);
  return all;
}

void expect_shares(const PartList& list, const std::vector<double>& expected) {
  const std::vector<double> all = shares(list);
  ASSERT_EQ(all.size(), expected.size());
  for (size_t i = 0; i < all.size(); ++i) EXPECT_NEAR(all[i], expected[i], 1e-12) << i;
}

TEST(PartList, UndividedObjectGetsTheWholeAndItsUpperHalf) {
  PartList list{MaterialParts()};
  list.add("oak", kBody);
  ASSERT_EQ(list.parts().size(), 2);
  expect_shares(list, {0.5, 0.5});
  EXPECT_NE(list.parts()[0].name(), list.parts()[1].name());
  EXPECT_EQ(list.parts()[1].material(), "oak");
  EXPECT_TRUE(list.parts()[0].boxes().empty());
  const PartPlaces places(list.parts());
  EXPECT_EQ(places.at({0, 0.19, 0}), 0u);
  EXPECT_EQ(places.at({0, 0.21, 0}), 1u);
  for (const Eigen::Vector3d& corner : {kBody.max(), Eigen::Vector3d(-0.1, 0.4, -0.2)})
    EXPECT_EQ(places.at(corner), 1u);
}

TEST(PartList, OtherSharesKeepTheirProportions) {
  PartList list = hammer();
  list.set_share(0, 0.75);
  expect_shares(list, {0.75, 0.15, 0.1});
  list.set_share(0, 7);
  expect_shares(list, {1, 0, 0});
  list.set_share(0, 0.5);  // the others have no proportion
  expect_shares(list, {0.5, 0.25, 0.25});
  list.set_share(1, NAN);
  expect_shares(list, {0.5, 0.25, 0.25});
}

TEST(PartList, AddedAndRemovedPartsLeaveASumOfOne) {
  PartList list = hammer();
  list.add("oak", kBody);
  expect_shares(list, {0.375, 0.225, 0.15, 0.25});
  EXPECT_EQ(list.parts()[3].name(), "part 1");
  list.remove(3);
  expect_shares(list, {0.5, 0.3, 0.2});
  list.remove(2);
  expect_shares(list, {0.625, 0.375});
  list.remove(1);
  expect_shares(list, {1});
  EXPECT_TRUE(list.parts()[0].boxes().empty()) << "one part is the whole object";
  list.remove(0);
  EXPECT_EQ(list.parts().size(), 1);
  list.set_share(0, 0.3);
  expect_shares(list, {1});
}

TEST(PartList, NamesMaterialsAndBoxesAreSet) {
  PartList list = hammer();
  list.rename(1, "shaft");
  list.set_material(1, "oak");
  EXPECT_EQ(list.parts()[1].name(), "shaft");
  EXPECT_EQ(list.parts()[1].material(), "oak");
  list.add_box(1, kBody);
  list.add_box(1, kBody);
  ASSERT_EQ(list.parts()[1].boxes_size(), 2);
  EXPECT_DOUBLE_EQ(list.parts()[1].boxes(0).min_m(1), 0.2);
  v1::MaterialPart::Box open;
  for (const double corner_m : {0.0, 0.1, 0.0}) open.add_max_m(corner_m);
  list.move_box(1, 1, open);
  list.remove_box(1, 0);
  ASSERT_EQ(list.parts()[1].boxes_size(), 1);
  EXPECT_TRUE(list.parts()[1].boxes(0).min_m().empty());
  EXPECT_EQ(list.parts()[1].boxes(0).max_m(1), 0.1);
  list.remove_box(1, 5);
  list.rename(9, "none");
  EXPECT_EQ(list.parts()[1].boxes_size(), 1);
}

// A language model may leave a name out, and the server refuses that in what is set by hand.
TEST(PartList, UnnamedPartsGetNamesAndDensitiesGo) {
  MaterialParts parts = hammer().parts();
  parts[0].clear_name();
  parts[0].set_density_kg_m3(1);
  const PartList list(parts);
  EXPECT_EQ(list.parts()[0].name(), "part 1");
  EXPECT_EQ(list.parts()[0].density_kg_m3(), 0);
  parts[0].set_density_kg_m3(2);
  EXPECT_EQ(list, PartList(parts));
  parts[0].set_mass_share(0.4);
  EXPECT_FALSE(list == PartList(parts));
}

}  // namespace
}  // namespace livegs
