// SPDX-License-Identifier: Apache-2.0
#include "splat/tiles/frame_tiles.h"

#include <algorithm>
#include <array>

#include "common/compute/backends.h"
#include "common/splat/synthetic_kernels.h"
#include "splat/rasterise.h"

namespace livegs {
namespace {

using synthetic::Object;

constexpr double kBar_db = 70.0;      // floats, against the CPU rasteriser
constexpr double kRounded_db = 57.0;  // 8 bits: rounding alone gives 20 log10(255 sqrt(12)) = 58.9 dB
const Eigen::Vector3f kGrey{0.2f, 0.3f, 0.4f};

class FrameTilesTest : public OnEveryBackend {
 protected:
  struct Settings {
    bool floats = true;
    uint32_t max_part_rows = 0, max_pairs = 0;
  };

  std::vector<Image> draw(const std::vector<const Object*>& objects, std::span<const Camera> eyes,
                          const Settings& settings) {
    std::vector<DeviceKernels> kernels;
    std::vector<FrameSplats::Object> in_frame;
    for (const Object* object : objects) {
      auto made = DeviceKernels::create(*backend_, object->asset);
      EXPECT_TRUE(made) << made.error().message;
      EXPECT_TRUE(made->pose(object->posed));
      kernels.push_back(*std::move(made));
    }
    for (size_t i = 0; i < kernels.size(); ++i) in_frame.push_back({&kernels[i], {}, objects[i]->id});
    FrameSplats frame(*backend_, settings.max_part_rows);
    const auto projected = frame.project(in_frame, eyes, {});
    EXPECT_TRUE(projected) << projected.error().message;
    EXPECT_TRUE(frame.sort());
    FrameTiles tiles(*backend_, {settings.floats, settings.max_pairs});
    std::vector<Image> images;
    error_.reset();
    EXPECT_TRUE(tiles.bin(frame, eyes[0].width, eyes[0].height, static_cast<int>(eyes.size())));
    EXPECT_TRUE(tiles.blend(kGrey));
    if (const auto done = tiles.finish(images); !done) error_ = done.error();
    return images;
  }

  static Image expected(const std::vector<const Object*>& objects, const Camera& eye, bool floats,
                        std::optional<Eigen::Vector3d> ordered_from_m = {}) {
    std::vector<DrawnObject> drawn;
    for (const Object* object : objects) drawn.push_back(object->drawn());
    RasteriseOptions options;
    if (!floats) options.background = kGrey;
    options.order = DepthOrder::Distance;
    options.distance_from_m = ordered_from_m;
    options.image_only = true;
    RasterisedView view;
    Rasteriser().draw(drawn, eye, options, view);
    return view.image;
  }

  std::optional<Error> error_;
};
INSTANTIATE_TEST_SUITE_P(Backend, FrameTilesTest, ::testing::Values("cpu", "vulkan"), backend_name);

Camera ahead(double distance_m, int width, int height) {
  return look_at({0.1, 0.2, distance_m}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.8, width, height);
}

Image clamped(Image image) {
  for (float& value : image.pixels) value = std::min(value, 1.0f);
  return image;
}

TEST_P(FrameTilesTest, MatchTheRasteriser) {
  const Object shell = synthetic::shell(3000, 3, 0.02, 1);
  for (const double distance_m : {1.6, 0.7, 0.1}) {  // from outside, near and inside
    for (const auto& [width, height] :
         {std::pair{160, 112}, std::pair{71, 93}}) {  // whole tiles, and cut ones
      SCOPED_TRACE(testing::Message() << distance_m << " m, " << width << " px");
      const Camera eye = ahead(distance_m, width, height);
      EXPECT_GE(psnr_db(draw({&shell}, {&eye, 1}, {})[0], expected({&shell}, eye, true)), kBar_db);
      EXPECT_GE(
          psnr_db(draw({&shell}, {&eye, 1}, {.floats = false})[0], clamped(expected({&shell}, eye, false))),
          kRounded_db);
    }
  }
}

TEST_P(FrameTilesTest, MatchTheRasteriserForTwoEyesAndObjects) {
  const Object near = synthetic::shell(1500, 1, 0.03, 2);
  Object far =
      synthetic::moved(synthetic::shell(1500, 2, 0.03, 3), {{0.2, 0, -0.3}, Eigen::Quaterniond::Identity()});
  far.id = 1;
  std::array<Camera, 2> eyes{ahead(1.4, 120, 100), ahead(1.4, 120, 100)};
  for (int e = 0; e < 2; ++e) eyes[e].world_from_camera.position_m.x() += e == 0 ? -0.032 : 0.032;
  const auto made = draw({&near, &far}, eyes, {});
  ASSERT_EQ(made.size(), 2u);
  const Eigen::Vector3d middle = ahead(1.4, 1, 1).world_from_camera.position_m;
  for (int e = 0; e < 2; ++e)
    EXPECT_GE(psnr_db(made[e], expected({&near, &far}, eyes[e], true, middle)), kBar_db) << e;
  EXPECT_LT(psnr_db(made[0], made[1]), 35.0);
}

// The buffers begin with four pairs per kernel.
TEST_P(FrameTilesTest, GrowForFramesWithMorePairs) {
  const Object wide = synthetic::shell(200, 0, 0.3, 4);  // each kernel touches most of the tiles
  const Camera eye = ahead(1.2, 320, 240);
  const Image made = draw({&wide}, {&eye, 1}, {})[0];
  EXPECT_GE(psnr_db(made, expected({&wide}, eye, true)), kBar_db);
}

// lavapipe ends the loops of a thread after 65 535 rounds; a tile may hold more kernels.
TEST_P(FrameTilesTest, BlendEveryKernelOfACrowdedTile) {
  const Object crowd = synthetic::shell(150'000, 0, 0.003, 7);
  const Camera eye = ahead(8, 24, 24);
  EXPECT_GE(psnr_db(draw({&crowd}, {&eye, 1}, {})[0], expected({&crowd}, eye, true)), kBar_db);
}

TEST_P(FrameTilesTest, RejectMorePairsThanTheDeviceHolds) {
  const Object wide = synthetic::shell(200, 0, 0.3, 4);
  const Camera eye = ahead(1.2, 320, 240);
  draw({&wide}, {&eye, 1}, {.max_pairs = 3000});
  ASSERT_TRUE(error_);
  EXPECT_EQ(error_->code, ErrorCode::TooLarge);
  EXPECT_NE(error_->message.find("pairs of tile and kernel exceed the limit of 3000"), std::string::npos)
      << error_->message;
}

TEST_P(FrameTilesTest, SplitRowsGiveTheSamePicture) {
  const Object shell = synthetic::shell(2000, 1, 0.03, 5);
  std::array<Camera, 2> eyes{ahead(1.2, 96, 80), ahead(1.2, 96, 80)};
  eyes[1].world_from_camera.position_m.x() += 0.064;
  const auto whole = draw({&shell}, eyes, {});
  const auto parts = draw({&shell}, eyes, {.max_part_rows = 700});
  for (int e = 0; e < 2; ++e) EXPECT_EQ(parts[e].pixels, whole[e].pixels);
}

TEST_P(FrameTilesTest, EmptyFrameIsTheBackground) {
  const Camera eye = ahead(1.2, 40, 24);
  const Image made = draw({}, {&eye, 1}, {.floats = false})[0];
  for (size_t i = 0; i < made.pixels.size(); i += 4) {
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(made.pixels[i + c], kGrey[c], 0.5 / 255 + 1e-6);
    EXPECT_EQ(made.pixels[i + 3], 0.0f);
  }
}

TEST_P(FrameTilesTest, RepeatedPictureIsBitIdentical) {
  const Object shell = synthetic::shell(2500, 2, 0.03, 6);
  const Camera eye = ahead(1.0, 130, 90);
  EXPECT_EQ(draw({&shell}, {&eye, 1}, {})[0].pixels, draw({&shell}, {&eye, 1}, {})[0].pixels);
}

}  // namespace
}  // namespace livegs
