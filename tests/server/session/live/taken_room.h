// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <thread>

#include "gaussian/asset_file.h"
#include "sample/made_room.h"
#include "scratch_folder.h"
#include "session/live/room_things.h"

// A captured room in a folder, whose things can be taken.

namespace livegs {

class TakenRoom : public testing::Test {
 protected:
  void SetUp() override {
    MadeRoomOptions made;
    made.spacing_m = 0.008;
    room_ = make_room(RoomKind::Apart, made);
    ASSERT_TRUE(write_asset(folder_.path() / "desk.ply", room_.asset));
    environment_.set_asset("desk.ply");
    things_ = ready();
  }
  std::unique_ptr<RoomThings> ready() {
    auto things = std::make_unique<RoomThings>(folder_.path());
    for (int i = 0; i < 2400 && things->describe(environment_).state() == v1::RoomParts::PREPARING; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(25));
    EXPECT_EQ(things->describe(environment_).state(), v1::RoomParts::READY);
    return things;
  }
  // Adds a pick ray from above and in front. `at`: its target in the bounds of the thing, 0 to 1 along each
  // axis of the world; y is up.
  void aim(v1::TakePartRequest& request, size_t thing, const Eigen::Vector3d& at, bool away) const {
    const Eigen::AlignedBox3d& box = room_.bounds_m[thing];
    const Eigen::Vector3d point(box.min().x() + at.x() * box.sizes().x(),
                                -box.max().y() + at.y() * box.sizes().y(),
                                -box.max().z() + at.z() * box.sizes().z());
    const Eigen::Vector3d from = point + Eigen::Vector3d(0.1, 0.5, 0.5);
    v1::PickRay& ray = *request.add_rays();
    for (int k = 0; k < 3; ++k) ray.add_from_m(from[k]), ray.add_towards(point[k] - from[k]);
    ray.set_away(away);
  }
  RoomThings::Thing under(const v1::TakePartRequest& request) {
    auto thing = things_->under(request, environment_);
    EXPECT_TRUE(thing) << thing.error().message;
    return thing ? *thing : RoomThings::Thing();
  }
  ScratchFolder folder_;
  MadeRoom room_;
  v1::Environment environment_;
  std::unique_ptr<RoomThings> things_;
};

}  // namespace livegs
