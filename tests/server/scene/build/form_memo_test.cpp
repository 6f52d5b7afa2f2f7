// SPDX-License-Identifier: Apache-2.0
#include "scene/build/form_memo.h"

#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <string>

#include "scene/build/build_object.h"

namespace livegs {
namespace {

v1::Object object_of(const std::string& json) {
  v1::Object object;
  EXPECT_TRUE(google::protobuf::util::JsonStringToMessage(json, &object).ok());
  return object;
}

RigidBodyDescription built(const std::string& json, FormMemo* forms) {
  auto object = build_object(object_of(json), "", 0, "objects[0]", WorldSettings{}, {}, forms);
  EXPECT_TRUE(object) << object.error().message;
  return std::get<RigidBodyDescription>(object->body);
}

std::string box(const std::string& name, double height_m, const std::string& more = "") {
  return R"({"name": ")" + name + R"(", "shape": {"box": {"sizeM": [0.2, )" + std::to_string(height_m) +
         R"(, 0.3]}}, "physics": {"behavior": "RIGID", "massKg": 2)" + more + "}}";
}

TEST(FormMemo, ObjectsOfEqualShapeShareTheirContactShape) {
  FormMemo forms;
  const RigidBodyDescription first = built(box("crate", 0.1), &forms);
  const RigidBodyDescription second = built(box("parcel", 0.1), &forms);
  const RigidBodyDescription other = built(box("crate", 0.11), &forms);
  ASSERT_TRUE(first.shape);
  EXPECT_EQ(first.shape, second.shape);
  EXPECT_NE(first.shape, other.shape);
}

// What is shared is what each object would compute alone.
TEST(FormMemo, SharedShapeIsThatOfTheObjectAlone) {
  FormMemo forms;
  for (const char* shape :
       {R"("box": {"sizeM": [0.2, 0.1, 0.3]})", R"("cylinder": {"radiusM": 0.1, "heightM": 0.3})",
        R"("capsule": {"radiusM": 0.1, "heightM": 0.4})"}) {
    const std::string json =
        std::string(R"({"name": "a", "shape": {)") + shape + R"(}, "physics": {"behavior": "RIGID"}})";
    (void)built(json, &forms);
    const RigidBodyDescription shared = built(json, &forms), alone = built(json, nullptr);
    ASSERT_TRUE(shared.shape && alone.shape);
    EXPECT_EQ(shared.shape->contact_points_m, alone.shape->contact_points_m);
    EXPECT_EQ(shared.shape->inner_radius_m, alone.shape->inner_radius_m);
    EXPECT_EQ(shared.properties.inertia_m2, alone.properties.inertia_m2);
    EXPECT_EQ(shared.material.mass_kg, alone.material.mass_kg);
  }
}

TEST(FormMemo, HundredsOfShapesReplaceTheOldest) {
  FormMemo forms;
  int made = 0;
  const auto value = [&](int key) { return *forms.value<int>(std::to_string(key), [&] { return ++made; }); };
  for (int i = 0; i < 300; ++i) value(i);
  EXPECT_EQ(value(299), 300);
  EXPECT_EQ(made, 300);
  value(0);
  EXPECT_EQ(made, 301);
}

}  // namespace
}  // namespace livegs
