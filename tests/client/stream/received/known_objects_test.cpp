// SPDX-License-Identifier: Apache-2.0
#include "stream/received/known_objects.h"

#include <gtest/gtest.h>

#include "wire/rest_body_codec.h"

namespace livegs {
namespace {

v1::ObjectDescription thing(uint32_t id, const std::string& name) {
  v1::ObjectDescription object;
  object.set_object_id(id);
  object.set_name(name);
  object.set_asset_hash(std::string(64, 'a'));
  RestBody rest;
  rest.bodies.resize(1);
  const std::vector<std::byte> bytes = encode_rest_body(rest);
  object.set_rest_body(bytes.data(), bytes.size());
  return object;
}

TEST(KnownObjects, ReportOnlyChanges) {
  KnownObjects objects;
  const v1::ObjectDescription hat = thing(1, "hat"), cup = thing(2, "cup"),
                              broken_cup = thing(2, "fragments"), ball = thing(3, "ball");
  const auto first = objects.replace(std::vector{&hat, &cup});
  ASSERT_TRUE(first);
  EXPECT_EQ(first->added.size(), 2u);
  const auto second = objects.replace(std::vector{&ball, &broken_cup});
  ASSERT_TRUE(second);
  ASSERT_EQ(second->added.size(), 1u);
  EXPECT_EQ(second->added[0].name, "ball");
  ASSERT_EQ(second->changed.size(), 1u);
  EXPECT_EQ(second->changed[0].name, "fragments");
  EXPECT_EQ(second->removed, std::vector<uint32_t>{1});
}

// Found by server_message_fuzz: a list with a duplicate id was reported as a change every time.
TEST(KnownObjects, RefuseDuplicateIds) {
  KnownObjects objects;
  const v1::ObjectDescription hat = thing(1, "hat"), cup = thing(1, "cup"), ball = thing(3, "ball");
  ASSERT_TRUE(objects.replace(std::vector{&ball}));
  const auto twice = objects.replace(std::vector{&hat, &cup});
  ASSERT_FALSE(twice);
  EXPECT_EQ(twice.error().message, "object \"cup\": its id belongs to another object");
  const auto again = objects.replace(std::vector{&ball});
  ASSERT_TRUE(again);
  EXPECT_TRUE(again->added.empty() && again->changed.empty() &&
              again->removed.empty());  // a failed update changes nothing
}

}  // namespace
}  // namespace livegs
