// SPDX-License-Identifier: Apache-2.0
#include "analysis/division/divide_by_looks.h"

#include <gtest/gtest.h>

#include "analysis/division/label_boxes.h"
#include "server/analysis/division/composite_objects.h"

namespace livegs {
namespace {

MaterialParts parts_of_row(const ObjectRow& row) {
  MaterialParts parts;
  for (const ObjectPart& part : row.parts) {
    v1::MaterialPart& one = *parts.Add();
    one.set_name(part.name);
    one.set_material(part.material);
    one.set_mass_share(part.mass_share);
  }
  return parts;
}

double right_share(const CompositeObject& object, const MaterialParts& parts) {
  const PartPlaces places(parts);
  size_t right = 0;
  for (size_t i = 0; i < object.part.size(); ++i) {
    const Eigen::Vector3d point = object.object_from_asset * object.asset.positions[i].cast<double>();
    right += places.at(point) == object.part[i] ? 1 : 0;
  }
  return static_cast<double>(right) / static_cast<double>(object.part.size());
}

TEST(DivideByLooks, KernelsOfEightObjectsGetTheirPart) {
  for (const CompositeObject& object : composite_objects()) {
    const ObjectRow& row = *find_object_row(object.name);
    const SurfaceKernels kernels = surface_kernels(object.asset, object.object_from_asset);
    MaterialParts parts = parts_of_row(row);
    const LooksDivision division = divide_by_looks(row.parts, kernels, parts);
    std::printf("%-14s %s\n", object.name.c_str(), division.reason.c_str());
    if (!division.divided) continue;
    const double right = right_share(object, parts);
    std::printf("%-14s %.1f %% of %zu kernels right\n", object.name.c_str(), 100 * right, object.part.size());
    EXPECT_GE(right, 0.6) << object.name;
    EXPECT_TRUE(check_parts(parts)) << check_parts(parts).error().message;
  }
}

TEST(DivideByLooks, ObjectOfOneColourAndWidthIsOnePart) {
  for (const CompositeObject& object : composite_objects()) {
    if (object.name != "lamp" && object.name != "potted plant") continue;
    const ObjectRow& row = *find_object_row(object.name);
    SurfaceKernels kernels = surface_kernels(object.asset, object.object_from_asset);
    // The form is replaced by a column with the same colours in any order.
    for (size_t i = 0; i < kernels.positions_m.size(); ++i) {
      const auto turn = static_cast<float>(i) * 2.4f;
      kernels.positions_m[i] = {0.05f * std::cos(turn),
                                static_cast<float>(i * 7919 % kernels.positions_m.size()) * 1e-4f,
                                0.05f * std::sin(turn)};
    }
    MaterialParts parts = parts_of_row(row);
    const LooksDivision division = divide_by_looks(row.parts, kernels, parts);
    EXPECT_FALSE(division.divided) << division.reason;
    EXPECT_FALSE(PartPlaces(parts).divided());
    EXPECT_TRUE(division.reason.starts_with("one part: ")) << division.reason;
  }
}

TEST(DivideByLooks, PartsWithoutAUsualPlaceAreNotDivided) {
  const CompositeObject object = composite_objects().front();
  const ObjectRow& bicycle = *find_object_row("bicycle");
  MaterialParts parts = parts_of_row(bicycle);
  EXPECT_FALSE(
      divide_by_looks(bicycle.parts, surface_kernels(object.asset, object.object_from_asset), parts).divided);
}

// A grid whose corner block has another label: one box suffices.
TEST(LabelBoxes, BlockInACornerIsSeparatedByOneBox) {
  std::vector<Eigen::Vector3f> points;
  std::vector<uint8_t> labels;
  for (int x = 0; x < 12; ++x)
    for (int y = 0; y < 12; ++y)
      for (int z = 0; z < 12; ++z) {
        points.push_back({0.1f * x, 0.1f * y, 0.1f * z});
        labels.push_back(x >= 6 && y >= 6 ? 1 : 0);
      }
  const std::vector<float> weights(points.size(), 1.0f);
  const auto boxes = label_boxes({points, weights, labels}, 2);
  ASSERT_EQ(boxes.size(), 2u);
  EXPECT_TRUE(boxes[0].empty());  // it has more leaves, so it is the rest
  ASSERT_EQ(boxes[1].size(), 1u);
  for (size_t i = 0; i < points.size(); ++i)
    EXPECT_EQ(boxes[1][0].contains(points[i].cast<double>()), labels[i] == 1) << i;
}

TEST(PartPlaces, LaterBoxAppliesAndPointsOutsideBelongToTheRest) {
  MaterialParts parts;
  for (const char* name : {"pot", "soil", "leaves"}) parts.Add()->set_name(name);
  set_boxes(std::vector<Eigen::AlignedBox3d>{{Eigen::Vector3d(-1, 0, -1), Eigen::Vector3d(1, 1, 1)}},
            parts[0]);
  set_boxes(std::vector<Eigen::AlignedBox3d>{{Eigen::Vector3d(-0.5, -9, -0.5), Eigen::Vector3d(0.5, 9, 0.5)}},
            parts[1]);
  const PartPlaces places(parts);
  ASSERT_TRUE(places.divided());
  EXPECT_EQ(places.at({0.8, 0.5, 0}), 0u);
  EXPECT_EQ(places.at({0.2, 0.5, 0}), 1u);
  EXPECT_EQ(places.at({3, 0.5, 0}), 2u);
  scale_parts(2, parts);
  EXPECT_EQ(PartPlaces(parts).at({1.8, 0.5, 0}), 0u);
  EXPECT_FALSE(PartPlaces(MaterialParts()).divided());
  // A box with an open corner is a half space along each axis.
  set_boxes(
      std::vector<Eigen::AlignedBox3d>{{Eigen::Vector3d::Constant(-INFINITY), Eigen::Vector3d(0, 0, 0)}},
      parts[1]);
  EXPECT_EQ(parts[1].boxes(0).min_m_size(), 0);
  EXPECT_EQ(PartPlaces(parts).at({-50, -50, -50}), 1u);
}

TEST(PartPlaces, FaultyPartsAreRefusedWithFieldAndRange) {
  MaterialParts parts = parts_of_row(*find_object_row("hammer"));
  EXPECT_TRUE(check_parts(parts));
  const auto refused = [&](const auto& spoil, const char* field) {
    MaterialParts faulty = parts;
    spoil(faulty);
    const auto checked = check_parts(faulty);
    ASSERT_FALSE(checked) << field;
    EXPECT_TRUE(checked.error().message.starts_with(field)) << checked.error().message;
  };
  refused([](MaterialParts& p) { p[1].set_material("unobtainium"); }, "parts[1].material");
  refused([](MaterialParts& p) { p[0].set_mass_share(-0.1); }, "parts[0].mass_share");
  refused([](MaterialParts& p) { p[0].set_mass_share(NAN); }, "parts[0].mass_share");
  refused([](MaterialParts& p) { p[0].set_mass_share(0.2); }, "parts: the mass shares sum to 0.5");
  refused([](MaterialParts& p) { p[0].set_youngs_modulus_pa(1e15); }, "parts[0].youngs_modulus_pa");
  refused([](MaterialParts& p) { p[0].add_boxes()->add_min_m(1); }, "parts[0].boxes[0].min_m");
  refused(
      [](MaterialParts& p) {
        auto& box = *p[0].add_boxes();
        for (int i = 0; i < 3; ++i) box.add_min_m(1), box.add_max_m(0);
      },
      "parts[0].boxes[0]");
  refused(
      [](MaterialParts& p) {
        while (p.size() <= kMaxMaterialParts) *p.Add() = p[0];
      },
      "parts: 9 are given");
}

}  // namespace
}  // namespace livegs
