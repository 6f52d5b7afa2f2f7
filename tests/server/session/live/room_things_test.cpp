// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/live/room_things.h"

#include "server/session/live/taken_room.h"

namespace livegs {
namespace {

TEST_F(TakenRoom, ARayThatTakesAwayDividesAThing) {
  v1::TakePartRequest request;
  aim(request, 0, {0.5, 0.2, 1}, false);
  const RoomThings::Thing whole = under(request);
  EXPECT_TRUE(whole.cut.empty()) << "one ray takes a thing as it was found";
  aim(request, 0, {0.5, 1, 0.5}, true);  // the top of the carton has another light than its front
  const RoomThings::Thing part = under(request);
  EXPECT_GT(part.kernels, whole.kernels / 4);
  EXPECT_LT(part.kernels, whole.kernels);
  EXPECT_EQ(part.labels, whole.labels);

  const size_t colliders = environment_.colliders_size();
  const auto taken = things_->take(part, environment_);
  ASSERT_TRUE(taken) << taken.error().message;
  EXPECT_NE(taken->object.part(), whole.labels[0]) << "the rest keeps its label";
  const auto asset = read_asset(folder_.path() / taken->object.asset());
  ASSERT_TRUE(asset);
  EXPECT_GE(asset->asset.size(), part.kernels);
  EXPECT_LT(asset->asset.size(), part.kernels + 2000);

  // A later process finds the rest where it was, and the part can be put back.
  environment_ = taken->environment;
  things_ = ready();
  bool rest = false;
  const v1::RoomParts parts = things_->describe(environment_);
  for (const v1::RoomParts::Part& one : parts.parts()) {
    if (one.label() == whole.labels[0])
      rest = !one.taken() && one.kernels() > 20 && one.kernels() < whole.kernels;
    if (one.label() == taken->object.part()) {
      EXPECT_TRUE(one.taken());
    }
  }
  EXPECT_TRUE(rest);
  v1::TakePartRequest again;
  aim(again, 0, {0.5, 1, 0.5}, false);
  EXPECT_EQ(under(again).labels, whole.labels);
  const auto back = things_->put_back(taken->object.part(), environment_);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->taken_size(), 0);
  EXPECT_EQ(back->colliders_size() > 0, taken->environment.colliders_size() > 0) << colliders;
}

TEST_F(TakenRoom, ARayThatTakesAwayFromAnotherThingKeepsTheFirst) {
  v1::TakePartRequest request;
  aim(request, 0, {0.5, 0.5, 1}, false);
  const RoomThings::Thing whole = under(request);
  aim(request, 1, {0.5, 0.5, 1}, true);
  EXPECT_EQ(under(request).labels, whole.labels);
  EXPECT_TRUE(under(request).cut.empty());
  v1::TakePartRequest floor;
  v1::PickRay& ray = *floor.add_rays();
  for (const double number : {0.0, 2.0, 0.0}) ray.add_from_m(number);
  for (const double number : {1.3, -2.0, 1.3}) ray.add_towards(number);
  EXPECT_FALSE(things_->under(floor, environment_));
}

}  // namespace
}  // namespace livegs
