// SPDX-License-Identifier: Apache-2.0
// Pictures of the sample scene: shadows under resting and lifted objects, and the floor around objects.
#include "client/render/renderer/renderer_fixture.h"
#include "render/scene_view.h"
#include "sample/sample_scene.h"
#include "splat/frame_bounds.h"

namespace livegs {
namespace {

constexpr int kViewWidth = 240, kViewHeight = 180;
constexpr uint32_t kRoomId = 100;

// The sample scene with every object standing on the floor.
class StandingSample : public VulkanPictures {
 protected:
  static void SetUpTestSuite() {
    VulkanPictures::SetUpTestSuite();
    assets = new std::vector<std::shared_ptr<const GaussianAsset>>();
    names = new std::vector<std::string>();
    for (SampleAsset& sample : make_sample_assets()) {
      assets->push_back(std::make_shared<const GaussianAsset>(std::move(sample.asset)));
      names->push_back(sample.name);
    }
  }
  static void TearDownTestSuite() {
    delete assets;
    delete names;
    VulkanPictures::TearDownTestSuite();
  }
  void SetUp() override {
    VulkanPictures::SetUp();
    RestBody rest;
    rest.bodies = {Pose{}};
    rest.object_from_asset.rotation = Eigen::Quaterniond(0, 1, 0, 0);
    for (uint32_t id = 0; id < assets->size(); ++id) {
      const bool room = (*names)[id] == "room";
      ASSERT_TRUE(view.add(room ? kRoomId : id, (*assets)[id], rest, room));
      if (!room) count = id + 1;
    }
    ASSERT_EQ(count, 6u);
    ASSERT_TRUE(view.pose(frame({})));
    for (uint32_t id = 0; id < count; ++id) boxes.push_back(view.bounds(id));
  }

  // `height_m`: of objects above the floor.
  DriverFrame frame(const std::map<uint32_t, double>& height_m, bool room = true,
                    const std::optional<uint32_t>& without = {}) const {
    DriverFrame made;
    for (uint32_t id = 0; id < count; ++id) {
      if (without == id) continue;
      const auto height = height_m.find(id);
      ObjectDrivers drivers;
      drivers.object_id = id;
      drivers.poses = {
          {{0.55 * (id % 3) - 0.55, height == height_m.end() ? 0.0 : height->second, 0.6 * (id / 3) - 0.5},
           Eigen::Quaterniond::Identity()}};
      made.objects.push_back(drivers);
    }
    if (!room) return made;
    ObjectDrivers still;
    still.object_id = kRoomId;
    still.poses = {Pose{}};
    made.objects.push_back(still);
    return made;
  }
  Camera towards(uint32_t id) const {
    return frame_boxes(std::span(&boxes[id], 1), kViewWidth, kViewHeight, 0.6, 0.5);
  }
  Image draw(const DriverFrame& drivers, const Camera& eye, bool shadows) {
    view.set_shadows(shadows);
    std::vector<Image> images;
    EXPECT_TRUE(view.draw(drivers, {&eye, 1}, images));
    return images.at(0);
  }

  static inline std::vector<std::shared_ptr<const GaussianAsset>>* assets = nullptr;
  static inline std::vector<std::string>* names = nullptr;
  SceneView view;
  uint32_t count = 0;
  std::vector<Eigen::AlignedBox3d> boxes;
};

float brightness(const float* pixel) { return pixel[0] + pixel[1] + pixel[2]; }

TEST_F(StandingSample, EveryRestingObjectHasAShadow) {
  for (uint32_t id = 0; id < count; ++id) {
    SCOPED_TRACE((*names)[id]);
    const Camera eye = towards(id);
    const Image shaded = draw(frame({}), eye, true), plain = draw(frame({}), eye, false),
                objects = draw(frame({}, false), eye, false);
    int dark = 0;
    float darkest = 1;
    for (int y = 0; y < kViewHeight; ++y) {
      for (int x = 0; x < kViewWidth; ++x) {
        if (objects.at(x, y)[3] > 0.01f) continue;  // not the floor alone
        const float kept = brightness(shaded.at(x, y)) / std::max(0.1f, brightness(plain.at(x, y)));
        EXPECT_LT(kept, 1.02f);
        dark += kept < 0.9f;
        darkest = std::min(darkest, kept);
      }
    }
    EXPECT_GT(dark, kViewWidth * kViewHeight / 200);
    EXPECT_LT(darkest, 0.8f);
  }
}

// An object far above the floor changes nothing there: the picture is that of a scene without it.
TEST_F(StandingSample, LiftedObjectHasNoShadowOnTheFloor) {
  for (uint32_t id = 0; id < count; ++id) {
    SCOPED_TRACE((*names)[id]);
    const Camera eye = towards(id);
    const double wide_m = std::max(boxes[id].sizes().x(), boxes[id].sizes().z());
    const Image lifted = draw(frame({{id, 4 * wide_m + 1.5}}), eye, true),
                without = draw(frame({}, true, id), eye, true);
    EXPECT_EQ(lifted.pixels, without.pixels);
    const Image near = draw(frame({{id, 0.6 * wide_m}}), eye, true);
    EXPECT_NE(near.pixels, without.pixels);
  }
}

// Within the outline of an object, the picture with the room is that of the objects alone: no floor shows
// through thin parts, such as the brim of the hat.
TEST_F(StandingSample, FloorDoesNotPierceRestingObjects) {
  for (uint32_t id = 0; id < count; ++id) {
    SCOPED_TRACE((*names)[id]);
    const Camera eye = towards(id);
    const Image scene = draw(frame({}), eye, false), objects = draw(frame({}, false), eye, false);
    int inside = 0, pierced = 0;
    for (int y = 2; y < kViewHeight - 2; ++y) {
      for (int x = 2; x < kViewWidth - 2; ++x) {
        float least = 1;
        for (int dy = -2; dy <= 2; ++dy) {
          for (int dx = -2; dx <= 2; ++dx) least = std::min(least, objects.at(x + dx, y + dy)[3]);
        }
        if (least < 0.98f) continue;
        ++inside;
        float most = 0;
        for (int c = 0; c < 3; ++c) most = std::max(most, std::abs(scene.at(x, y)[c] - objects.at(x, y)[c]));
        pierced += most > 0.08f;
      }
    }
    RecordProperty((*names)[id] + "_pierced", pierced);
    ASSERT_GT(inside, 500);
    EXPECT_LT(pierced, inside / 200);
  }
}

// Blending in halves leaves 41 dB here, where hundreds of kernels cover a pixel; the light of each kernel is
// compared to 1e-5 in project_splats_test. Without shadows the pictures differ more.
TEST_F(StandingSample, VulkanDrawsTheSameShadows) {
  SceneView device(std::move(renderer_));
  RestBody rest;
  rest.bodies = {Pose{}};
  rest.object_from_asset.rotation = Eigen::Quaterniond(0, 1, 0, 0);
  for (uint32_t id = 0; id < assets->size(); ++id) {
    const bool room = (*names)[id] == "room";
    ASSERT_TRUE(device.add(room ? kRoomId : id, (*assets)[id], rest, room));
  }
  const Camera eye = frame_boxes(boxes, kViewWidth, kViewHeight, 0.6, 0.5);
  for (const double height_m : {0.0, 0.1}) {
    std::vector<Image> made;
    ASSERT_TRUE(device.draw(frame({{2, height_m}}), {&eye, 1}, made));
    EXPECT_GE(psnr_db(made[0], draw(frame({{2, height_m}}), eye, true)), 40.5);
    EXPECT_LT(psnr_db(made[0], draw(frame({{2, height_m}}), eye, false)), 40);
  }
}

}  // namespace
}  // namespace livegs
