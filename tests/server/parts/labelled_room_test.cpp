// SPDX-License-Identifier: Apache-2.0
#include "parts/labelled_room.h"

#include <gtest/gtest.h>

#include "core/file.h"
#include "gaussian/asset_file.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

// Kernel i lies at x = i.
LabelledRoom small_room(std::vector<uint16_t> labels) {
  LabelledRoom room;
  room.asset.resize(labels.size());
  for (size_t i = 0; i < labels.size(); ++i) {
    room.asset.positions[i] = {static_cast<float>(i), 0, 0};
    room.asset.rotations[i].setIdentity();
    room.asset.log_scales[i].setConstant(-3);
    room.asset.opacity_logits[i] = 2;
    room.asset.sh_dc[i].setZero();
  }
  room.label = std::move(labels);
  return room;
}

std::vector<int> places(const GaussianAsset& asset) {
  std::vector<int> all;
  for (const Eigen::Vector3f& position : asset.positions) all.push_back(static_cast<int>(position.x()));
  return all;
}

const LabelledRoom& two_things() {
  static const LabelledRoom room =
      small_room({0, 1, 2, label_of(KernelKind::Fill, 1), label_of(KernelKind::Covered, 1),
                  label_of(KernelKind::Underside, 1), label_of(KernelKind::Fill, 2), 1});
  return room;
}

TEST(LabelledRoom, TakenThingsLeaveTheRoomAndTheirFillsComeIn) {
  const std::vector<uint32_t> none, one{1}, both{1, 2};
  EXPECT_EQ(places(room_without(two_things(), none)), (std::vector<int>{0, 1, 2, 4, 7}));
  std::vector<uint32_t> kept;
  EXPECT_EQ(places(room_without(two_things(), one, &kept)), (std::vector<int>{0, 2, 3}));
  EXPECT_EQ(kept, (std::vector<uint32_t>{0, 2, 3}));
  EXPECT_EQ(places(room_without(two_things(), both)), (std::vector<int>{0, 3, 6}));
  EXPECT_EQ(places(thing_alone(two_things(), 1)), (std::vector<int>{1, 5, 7}));
  EXPECT_EQ(places(thing_alone(two_things(), 3)), (std::vector<int>{}));
}

TEST(LabelledRoom, IsReadAsWrittenAndRefusesBadFiles) {
  const ScratchFolder folder;
  const auto path = folder.path() / "desk.labels";
  ASSERT_TRUE(write_labelled_room(path, two_things()));
  const auto read = read_labelled_room(path);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->label, two_things().label);
  EXPECT_EQ(places(read->asset), places(two_things().asset));

  const std::vector<std::byte> good = read_file(path).value();
  const auto refusal = [&](std::vector<std::byte> bytes) {
    EXPECT_TRUE(write_file_atomically(path, bytes));
    const auto room = read_labelled_room(path);
    return room ? "read" : room.error().message;
  };
  for (size_t size = 0; size < good.size(); ++size)
    EXPECT_NE(refusal({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)}), "read") << size;
  for (size_t at = 0; at < 16; ++at) {
    std::vector<std::byte> bad = good;
    bad[at] ^= std::byte{0xff};
    EXPECT_NE(refusal(bad), "read") << at;
  }
  EXPECT_EQ(refusal(good), "read");
  ASSERT_TRUE(write_asset(folder.path() / "desk.ply", small_room({0, 0}).asset));
  EXPECT_NE(refusal(good).find("8 labels for 2 kernels"), std::string::npos);
}

}  // namespace
}  // namespace livegs
