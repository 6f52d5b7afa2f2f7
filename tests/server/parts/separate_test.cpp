// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>

#include "gaussian/opacity.h"
#include "parts/label/choose_kernels.h"
#include "parts/labelled_room.h"
#include "parts/separate/fill_behind.h"
#include "parts/separate/split_straddling.h"
#include "parts/views/room_view.h"
#include "sample/made_room.h"
#include "server/parts/fill_scores.h"
#include "server/parts/part_scores.h"
#include "splat/rasterise.h"

namespace livegs {
namespace {

constexpr int kPictureWidth = 240;

Image draw_one(const GaussianAsset& asset, const Camera& camera) {
  const PosedKernels posed = pose_in_place(asset);
  const DrawnObject object{&asset, &posed, 0};
  Rasteriser rasteriser;
  RasterisedView view;
  rasteriser.draw(std::span(&object, 1), camera, {}, view);
  return view.image;
}

// A round kernel of a thing whose mean is on the support is halved: each half has the mean at ± sqrt(2 / pi)
// deviations and a share of a half of the integral (half-normal distribution).
TEST(SplitStraddling, HalvesAKernelAtTheSupport) {
  GaussianAsset asset;
  asset.resize(1);
  asset.positions[0].setZero();
  asset.rotations[0].setIdentity();
  const double deviation_m = 0.001;
  asset.log_scales[0].setConstant(static_cast<float>(std::log(deviation_m)));
  asset.opacity_logits[0] = 0;  // opacity 0.5
  RoomParts parts;
  parts.label = {1};
  parts.share = {1};
  parts.footprint_m = 0.0011;  // a half reaches 1.01 deviations across the border, which is allowed
  parts.parts.resize(1);
  parts.parts[0].label = 1;
  parts.parts[0].support = 0;
  parts.planes.supports.resize(1);  // y = 0
  const SplitRoom split = split_straddling(asset, parts);
  EXPECT_EQ(split.split_count, 1u);
  double mass[2] = {}, mean_m[2] = {};
  for (size_t k = 0; k < split.asset.size(); ++k) {
    const double one = opacity_of_logit(split.asset.opacity_logits[k]) *
                       std::exp(static_cast<double>(split.asset.log_scales[k].sum()));
    mass[split.label[k]] += one;
    mean_m[split.label[k]] += one * split.asset.positions[k].y();
  }
  const double whole = 0.5 * std::pow(deviation_m, 3);
  EXPECT_NEAR(mass[0], 0.5 * whole, 1e-5 * whole);  // floats
  EXPECT_NEAR(mass[1], 0.5 * whole, 1e-5 * whole);
  EXPECT_NEAR(mean_m[1] / mass[1], std::sqrt(2 / M_PI) * deviation_m, 1e-5 * deviation_m);
  EXPECT_NEAR(mean_m[0] / mass[0], -std::sqrt(2 / M_PI) * deviation_m, 1e-5 * deviation_m);
}

class SeparatedRoom : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    MadeRoomOptions made;
    made.spacing_m = 0.006;
    room = new MadeRoom(make_room(RoomKind::Apart, made));
    PartsOptions options;
    options.view_width = kPictureWidth;
    options.cameras = orbit(room->middle_m, options.up, 1.1, 12, kPictureWidth, 0.0, 2 * M_PI);
    auto result = find_parts(room->asset, options);
    ASSERT_TRUE(result);
    found = new RoomParts(std::move(*result));
    split = new SplitRoom(split_straddling(room->asset, *found));
  }
  static void TearDownTestSuite() { delete room, delete found, delete split; }
  static inline MadeRoom* room = nullptr;
  static inline RoomParts* found = nullptr;
  static inline SplitRoom* split = nullptr;
};

TEST_F(SeparatedRoom, PartsTogetherGiveTheInputPicture) {
  for (const Camera& camera : orbit(room->middle_m, {0, -1, 0}, 1.1, 3, kPictureWidth, 0.4, 2 * M_PI))
    EXPECT_GE(psnr_db(draw_one(room->asset, camera), draw_one(split->asset, camera)), 45.0);
}

TEST_F(SeparatedRoom, ThingsEndAtTheirSupport) {
  const RoomPlane& desk = found->planes.supports[0];
  for (size_t k = 0; k < split->asset.size(); ++k) {
    if (split->label[k] == kRoomLabel) continue;
    const Eigen::Matrix3d axes =
        split->asset.rotations[k].cast<double>().toRotationMatrix() *
        split->asset.log_scales[k].cast<double>().array().exp().matrix().asDiagonal();
    const double deviation_m = (desk.normal.transpose() * axes).norm();
    // A pixel is allowed across a border, and kernels under half a pixel are not split.
    EXPECT_GE(desk.height_m(split->asset.positions[k].cast<double>()) - 3 * deviation_m,
              -2.6 * found->footprint_m);
  }
}

TEST_F(SeparatedRoom, DeskUnderAThingIsClosed) {
  for (size_t p = 0; p < found->parts.size(); ++p) {
    const BehindThing behind = fill_behind(*split, *found, p);
    ASSERT_GT(behind.fill.size(), 4u);
    EXPECT_GT(behind.underside.size(), 2u);
    for (const Eigen::Vector3f& at : behind.fill.positions) EXPECT_NEAR(at.y(), -0.72, 0.002);
  }
}

TEST_F(SeparatedRoom, ThingsAloneHaveTheirOutlines) {
  const LabelledRoom labelled = label_room(room->asset, *found);
  const auto cameras = orbit(room->middle_m, {0, -1, 0}, 1.1, 3, kPictureWidth, 0.4, 2 * M_PI);
  std::vector<std::vector<uint16_t>> truth, pictures;
  for (const Camera& camera : cameras) {
    truth.push_back(label_picture(room->asset, room->owner, camera));
    pictures.push_back(label_picture(room->asset, found->label, camera));
  }
  const std::vector<std::vector<uint8_t>> hidden(cameras.size(), std::vector<uint8_t>(truth[0].size(), 0));
  for (const ThingScore& thing : score_parts(truth, pictures, kPictureWidth).things) {
    std::vector<uint32_t> own;
    for (uint32_t k = 0; k < room->owner.size(); ++k)
      if (room->owner[k] == thing.truth) own.push_back(k);
    std::vector<std::vector<uint8_t>> masks;
    for (const Camera& camera : cameras) {
      const Image image = draw_one(select_kernels(room->asset, own), camera);
      std::vector<uint8_t>& mask = masks.emplace_back();
      for (size_t i = 3; i < image.pixels.size(); i += 4) mask.push_back(image.pixels[i] >= 0.5f);
    }
    const AloneScore alone = score_alone(thing_alone(labelled, thing.label), cameras, masks, hidden);
    EXPECT_GE(alone.iou, 0.93) << room->names[thing.truth - 1];
    EXPECT_GE(alone.boundary_iou, 0.9) << room->names[thing.truth - 1];
  }
}

// The room made without a thing is what a camera would see behind it.
TEST_F(SeparatedRoom, WithoutAThingItLooksLikeTheRoomMadeWithoutIt) {
  const LabelledRoom labelled = label_room(room->asset, *found);
  const auto cameras = orbit(room->middle_m, {0, -1, 0}, 1.1, 3, kPictureWidth, 0.4, 2 * M_PI);
  std::vector<std::vector<uint16_t>> truth, pictures;
  for (const Camera& camera : cameras) {
    truth.push_back(label_picture(room->asset, room->owner, camera));
    pictures.push_back(label_picture(room->asset, found->label, camera));
  }
  const PartScores scores = score_parts(truth, pictures, kPictureWidth);
  for (const size_t thing : {0, 2}) {  // a carton and a mug
    ASSERT_GT(scores.things[thing].iou, 0.8);
    MadeRoomOptions without;
    without.spacing_m = 0.006;
    without.without = thing;
    const uint32_t taken[] = {scores.things[thing].label};
    const FillScores fill = score_fill(room->asset, make_room(RoomKind::Apart, without).asset,
                                       room_without(labelled, taken), cameras);
    ASSERT_GT(fill.hole_pixels, 100u);
    EXPECT_GE(fill.psnr_db, 28.0) << room->names[thing];
    EXPECT_GE(fill.rim_psnr_db, 28.0) << room->names[thing];
    EXPECT_LE(fill.depth_p95_mm, 2.0) << room->names[thing];
    EXPECT_EQ(fill.open_share, 0.0) << room->names[thing];
  }
}

}  // namespace
}  // namespace livegs
