// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "core/parallel_for.h"
#include "parts/room_parts.h"
#include "sample/made_room.h"
#include "server/parts/part_scores.h"

namespace livegs {
namespace {

constexpr int kWidth = 240;

PartsOptions made_options(const MadeRoom& room, size_t views) {
  PartsOptions options;
  options.up = {0, -1, 0};
  options.view_width = kWidth;
  options.cameras = orbit(room.middle_m, options.up, 1.1, views, kWidth, 0.0, 2 * M_PI);
  return options;
}

TEST(FindParts, FindsThingsThatStandApart) {
  MadeRoomOptions made;
  made.spacing_m = 0.006;
  const MadeRoom room = make_room(RoomKind::Apart, made);
  const auto found = find_parts(room.asset, made_options(room, 16));
  ASSERT_TRUE(found) << found.error().message;
  std::vector<std::vector<uint16_t>> truth, pictures;
  for (const Camera& camera : orbit(room.middle_m, {0, -1, 0}, 1.1, 4, kWidth, 0.2, 2 * M_PI)) {
    truth.push_back(label_picture(room.asset, room.owner, camera));
    pictures.push_back(label_picture(room.asset, found->label, camera));
  }
  const PartScores scores = score_parts(truth, pictures, kWidth);
  EXPECT_EQ(scores.found, 5u);
  EXPECT_EQ(scores.extra, 0u);
  EXPECT_GE(scores.mean_iou, 0.95);
  for (const RoomPart& part : found->parts) EXPECT_TRUE(part.support.has_value());
  ASSERT_FALSE(found->planes.supports.empty());
  // A desk of 0.72 m, seen with pixels of about 5 mm.
  EXPECT_NEAR(found->planes.supports[0].height_m({0, -0.72, 0}), 0, 0.002);
}

// A crate hides the corner of the room in which it stands, and a cream stripe of a bin has the colour of the
// floor: both are whole.
TEST(FindParts, ThingsInACornerAreWhole) {
  MadeRoomOptions made;
  made.spacing_m = 0.008;
  const MadeRoom room = make_room(RoomKind::Corner, made);
  PartsOptions options;
  options.view_width = kWidth;
  options.cameras = orbit(room.middle_m, options.up, 1.6, 12, kWidth, -M_PI / 2 - 0.2, 2.0);
  const auto found = find_parts(room.asset, options);
  ASSERT_TRUE(found) << found.error().message;
  std::vector<std::vector<uint16_t>> truth, pictures;
  for (const Camera& camera : orbit(room.middle_m, options.up, 1.6, 3, kWidth, -M_PI / 2 + 0.1, 1.5)) {
    truth.push_back(label_picture(room.asset, room.owner, camera));
    pictures.push_back(label_picture(room.asset, found->label, camera));
  }
  const PartScores scores = score_parts(truth, pictures, kWidth);
  for (const ThingScore& thing : scores.things) EXPECT_GE(thing.iou, 0.96) << room.names[thing.truth - 1];
}

TEST(FindParts, SameLabelsForAnyThreadCount) {
  MadeRoomOptions made;
  made.spacing_m = 0.01;
  const MadeRoom room = make_room(RoomKind::Apart, made);
  std::vector<uint16_t> first;
  for (int threads : {1, 2, 8}) {
    set_thread_count(threads);
    const auto found = find_parts(room.asset, made_options(room, 6));
    ASSERT_TRUE(found);
    if (threads == 1) first = found->label;
    EXPECT_EQ(found->label, first);
  }
  set_thread_count(0);
}

TEST(FindParts, EmptyRoomHasNoParts) {
  MadeRoomOptions made;
  made.spacing_m = 0.01;
  const MadeRoom room = make_room(RoomKind::Empty, made);
  const auto found = find_parts(room.asset, made_options(room, 8));
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_TRUE(found->parts.empty());
}

TEST(FindParts, RefusesASplatOfOneKernel) {
  GaussianAsset one;
  one.resize(1);
  one.rotations[0].setIdentity();
  one.log_scales[0].setConstant(-3);
  const auto found = find_parts(one, {});
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().message,
            "room: has 1 kernels, too few to form a surface; give the splat of a room");
}

TEST(LiftLabels, ThreeTruePicturesLabelAlmostAllKernels) {
  MadeRoomOptions made;
  made.spacing_m = 0.006;
  const MadeRoom room = make_room(RoomKind::Touching, made);
  std::vector<LabelPicture> pictures;
  for (const Camera& camera : orbit(room.middle_m, {0, -1, 0}, 1.1, 3, kWidth, 0.3, 2 * M_PI))
    pictures.push_back({camera, label_picture(room.asset, room.owner, camera)});
  const auto found = lift_labels(room.asset, pictures, made_options(room, 4));
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->parts.size(), 6u);
  size_t equal = 0, things = 0;
  for (size_t k = 0; k < room.owner.size(); ++k) {
    if (room.owner[k] == 0) continue;
    ++things;
    equal += found->label[k] == room.owner[k];
  }
  EXPECT_GE(equal, 95 * things / 100);
}

}  // namespace
}  // namespace livegs
