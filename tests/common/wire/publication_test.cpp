// SPDX-License-Identifier: Apache-2.0
#include "wire/publication.h"

#include <gtest/gtest.h>

#include "common/wire/mutations.h"

namespace livegs {
namespace {

Publication some() {
  Publication publication;
  publication.server_instance = "00112233445566778899aabbccddeeff";
  publication.event_number = 7;
  publication.stepped_ns = 123456789;
  publication.frame.tick = 42;
  publication.frame.simulated_ns = 466666666;
  for (uint32_t id : {3u, 9u}) {
    ObjectDrivers drivers;
    drivers.object_id = id;
    drivers.kind = DriverKind::Lattice;
    for (int i = 0; i < 50; ++i)
      drivers.positions_m.emplace_back(0.01f * static_cast<float>(i), 0.5f, static_cast<float>(id));
    publication.frame.objects.push_back(drivers);
  }
  return publication;
}

TEST(Publication, IsSelfContained) {
  const auto read = decode_publication(encode_publication(some()));
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->server_instance, some().server_instance);
  EXPECT_EQ(read->event_number, 7u);
  EXPECT_EQ(read->stepped_ns, 123456789);
  EXPECT_EQ(read->frame.tick, 42u);
  ASSERT_EQ(read->frame.objects.size(), 2u);
  // Half a step of 15/16 of 2^-14 m on each axis.
  for (int i = 0; i < 50; ++i)
    EXPECT_LE((read->frame.objects[0].positions_m[i] - some().frame.objects[0].positions_m[i])
                  .cwiseAbs()
                  .maxCoeff(),
              2.87e-5f);
}

// proto/frame_format.md, "Publications".
TEST(Publication, MatchesTheFormatPage) {
  Publication publication = some();
  publication.frame = DriverFrame{1, 11111111, {}};
  const std::vector<std::byte> bytes = encode_publication(publication);
  std::vector<int> head;
  for (size_t i = 0; i < 34; ++i) head.push_back(std::to_integer<int>(bytes[i]));
  EXPECT_EQ(head, (std::vector<int>{0xD7, 0x01, 0x00, 0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88, 0x99,
                                    0xAA, 0xBB, 0xCC, 0xDD, 0xEE, 0xFF, 0x07, 0,    0,    0,    0,    0,
                                    0,    0,    0x15, 0xCD, 0x5B, 0x07, 0,    0,    0,    0}));
  EXPECT_EQ(std::to_integer<int>(bytes[34]), 0xD6);  // magic of the keyframe
}

TEST(Publication, MutationsAreRejectedOrRead) {
  const std::vector<std::byte> good = encode_publication(some());
  for (size_t size = 0; size < good.size(); ++size)
    EXPECT_FALSE(decode_publication(std::span(good).first(size)));
  testing::for_each_mutation(good, 20000, 3, [](std::span<const std::byte> spoilt) {
    const auto read = decode_publication(spoilt);
    if (!read) {
      EXPECT_FALSE(read.error().message.empty());
    }
  });
}

}  // namespace
}  // namespace livegs
