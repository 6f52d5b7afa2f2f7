// SPDX-License-Identifier: Apache-2.0
#include "scene/build/build_cache.h"

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

RigidBodyDescription built(const std::string& json, BuildCache* cache) {
  auto object = build_object(object_of(json), "", 0, "objects[0]", WorldSettings{}, {}, cache);
  EXPECT_TRUE(object) << object.error().message;
  return std::get<RigidBodyDescription>(object->body);
}

std::string box(const std::string& name, double height_m, const std::string& more = "") {
  return R"({"name": ")" + name + R"(", "shape": {"box": {"sizeM": [0.2, )" + std::to_string(height_m) +
         R"(, 0.3]}}, "physics": {"behavior": "RIGID", "massKg": 2)" + more + "}}";
}

TEST(BuildCache, ObjectsOfEqualShapeShareTheirContactShape) {
  BuildCache cache;
  const RigidBodyDescription first = built(box("crate", 0.1), &cache);
  const RigidBodyDescription second = built(box("parcel", 0.1), &cache);
  const RigidBodyDescription other = built(box("crate", 0.11), &cache);
  ASSERT_TRUE(first.shape);
  EXPECT_EQ(first.shape, second.shape);
  EXPECT_NE(first.shape, other.shape);
}

// What is shared is what each object would compute alone.
TEST(BuildCache, SharedShapeIsThatOfTheObjectAlone) {
  BuildCache cache;
  for (const char* shape :
       {R"("box": {"sizeM": [0.2, 0.1, 0.3]})", R"("cylinder": {"radiusM": 0.1, "heightM": 0.3})",
        R"("capsule": {"radiusM": 0.1, "heightM": 0.4})"}) {
    const std::string json =
        std::string(R"({"name": "a", "shape": {)") + shape + R"(}, "physics": {"behavior": "RIGID"}})";
    (void)built(json, &cache);
    const RigidBodyDescription shared = built(json, &cache), alone = built(json, nullptr);
    ASSERT_TRUE(shared.shape && alone.shape);
    EXPECT_EQ(shared.shape->contact_points_m, alone.shape->contact_points_m);
    EXPECT_EQ(shared.shape->inner_radius_m, alone.shape->inner_radius_m);
    EXPECT_EQ(shared.properties.inertia_m2, alone.properties.inertia_m2);
    EXPECT_EQ(shared.material.mass_kg, alone.material.mass_kg);
  }
}

TEST(BuildCache, ValuesOverTheLimitReplaceThoseUnusedForLongest) {
  BuildCache cache(30);
  int made = 0;
  const auto value = [&](int key) {
    return *cache.value<int>(
        std::to_string(key), [&] { return ++made; }, [](int) { return size_t{10}; });
  };
  for (const int key : {1, 2, 3}) value(key);
  EXPECT_EQ(value(1), 1);  // now 2 is unused for longest
  EXPECT_EQ(value(4), 4);
  EXPECT_EQ(value(1), 1);
  EXPECT_EQ(value(3), 3);
  EXPECT_EQ(value(2), 5);
}

TEST(BuildCache, AValueLargerThanTheLimitIsKeptAlone) {
  BuildCache cache(30);
  cache.keep("small", std::make_shared<const int>(1), 10);
  cache.keep("large", std::make_shared<const int>(2), 100);
  EXPECT_FALSE(cache.find<int>("small"));
  EXPECT_EQ(*cache.find<int>("large"), 2);
}

}  // namespace
}  // namespace livegs
