// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <utility>

#include "render/choose_camera.h"
#include "render/scene_view.h"
#include "splat/image.h"

namespace livegs {
namespace {

// A grid of opaque grey kernels that fills a cube of `edge` units around the asset's origin.
std::shared_ptr<const GaussianAsset> cube_asset(float edge, const Eigen::Vector3f& dc) {
  constexpr int kSide = 8;
  auto asset = std::make_shared<GaussianAsset>();
  asset->resize(kSide * kSide * kSide);
  for (size_t i = 0; i < asset->size(); ++i) {
    const Eigen::Vector3f cell(static_cast<float>(i % kSide), static_cast<float>(i / kSide % kSide),
                               static_cast<float>(i / kSide / kSide));
    asset->positions[i] = edge * ((cell / (kSide - 1)).array() - 0.5f);
    asset->log_scales[i].setConstant(std::log(edge / (2 * kSide)));
    asset->rotations[i].setIdentity();
    asset->opacity_logits[i] = 4.0f;
    asset->sh_dc[i] = dc;
  }
  return asset;
}

RestBody rigid_rest() {
  RestBody rest;
  rest.bodies = {Pose{}};
  return rest;
}

DriverFrame frame_of(std::initializer_list<std::pair<uint32_t, Eigen::Vector3d>> places) {
  DriverFrame frame;
  for (const auto& [id, position] : places) {
    ObjectDrivers drivers;
    drivers.object_id = id;
    drivers.poses = {{position, Eigen::Quaterniond::Identity()}};
    frame.objects.push_back(drivers);
  }
  return frame;
}

TEST(SceneView, SkinsOnlyMovedObjects) {
  SceneView view;
  ASSERT_TRUE(view.add(1, cube_asset(0.2f, {1, 0, 0}), rigid_rest(), false));
  ASSERT_TRUE(view.add(2, cube_asset(0.2f, {0, 1, 0}), rigid_rest(), false));
  const Camera camera = look_at({0, 0, 2}, {0, 0, 0}, {0, 1, 0}, 0.7, 96, 64);
  std::vector<Image> picture;
  ASSERT_TRUE(view.draw(frame_of({{1, {0, 0, 0}}, {2, {1, 0, 0}}}), {&camera, 1}, picture));
  EXPECT_EQ(view.last_times().objects_skinned, 2u);
  ASSERT_TRUE(view.draw(frame_of({{1, {0, 0, 0}}, {2, {1.5, 0, 0}}}), {&camera, 1}, picture));
  EXPECT_EQ(view.last_times().objects_moved, 1u);
  EXPECT_EQ(view.last_times().objects_skinned, 1u);
  EXPECT_NEAR(view.bounds(2).center().x(), 1.5, 1e-6);
  EXPECT_EQ(view.last_times().objects_skinned, 1u);
}

TEST(SceneView, VersionChangesWithEverythingThatMayChangeAPicture) {
  SceneView view;
  ASSERT_TRUE(view.add(1, cube_asset(0.2f, {1, 0, 0}), rigid_rest(), false));
  ASSERT_TRUE(view.add(2, cube_asset(0.2f, {0, 1, 0}), rigid_rest(), false));
  uint64_t last = 0;
  const auto changed = [&] { return std::exchange(last, view.version()) != view.version(); };
  EXPECT_TRUE(changed());
  ASSERT_TRUE(view.pose(frame_of({{1, {0, 0, 0}}, {2, {1, 0, 0}}})));
  EXPECT_TRUE(changed());
  ASSERT_TRUE(view.pose(frame_of({{1, {0, 0, 0}}, {2, {1, 0, 0}}})));
  (void)view.pick({1, 0, 2}, {0, 0, -1});
  EXPECT_FALSE(changed());
  ASSERT_TRUE(view.pose(frame_of({{1, {0, 0, 0}}, {2, {1, 1e-9, 0}}})));
  EXPECT_TRUE(changed());
  ASSERT_TRUE(view.pose(frame_of({{2, {1, 1e-9, 0}}})));  // object 1 is hidden
  EXPECT_TRUE(changed());
  auto finer = bind_object(2, cube_asset(0.2f, {0, 0, 1}), rigid_rest(), false);
  ASSERT_TRUE(finer);
  view.refine(2, *std::move(finer));
  EXPECT_TRUE(changed());
  view.remove(2);
  EXPECT_TRUE(changed());
}

// Positions are computed on a query, not for every pose.
TEST(SceneView, SkinsOnlyQueriedObjects) {
  SceneView view;
  ASSERT_TRUE(view.add(1, cube_asset(0.2f, {1, 0, 0}), rigid_rest(), false));
  ASSERT_TRUE(view.add(2, cube_asset(0.2f, {0, 1, 0}), rigid_rest(), false));
  ASSERT_TRUE(view.pose(frame_of({{1, {0, 0, 0}}, {2, {1, 0, 0}}})));
  EXPECT_EQ(view.last_times().objects_skinned, 0u);
  EXPECT_FALSE(view.pick({0.5, 0, 2}, {0, 0, -1}));  // between them
  EXPECT_EQ(view.last_times().objects_skinned, 0u);
  const auto picked = view.pick({1, 0, 2}, {0, 0, -1});
  ASSERT_TRUE(picked);
  EXPECT_EQ(picked->object_id, 2u);
  EXPECT_EQ(view.last_times().objects_skinned, 1u);
}

TEST(SceneView, CachedSkinningGivesSamePicture) {
  const Camera camera = look_at({0, 0, 2}, {0, 0, 0}, {0, 1, 0}, 0.7, 96, 64);
  SceneView kept, fresh;
  for (SceneView* view : {&kept, &fresh}) {
    ASSERT_TRUE(view->add(1, cube_asset(0.3f, {1, 0, 0}), rigid_rest(), false));
    ASSERT_TRUE(view->add(2, cube_asset(0.3f, {0, 1, 0}), rigid_rest(), false));
  }
  std::vector<Image> kept_picture, fresh_picture;
  ASSERT_TRUE(kept.draw(frame_of({{1, {-0.3, 0, 0}}, {2, {0.1, 0, 0}}}), {&camera, 1}, kept_picture));
  ASSERT_TRUE(kept.draw(frame_of({{1, {-0.3, 0, 0}}, {2, {0.3, 0, 0}}}), {&camera, 1}, kept_picture));
  ASSERT_TRUE(fresh.draw(frame_of({{1, {-0.3, 0, 0}}, {2, {0.3, 0, 0}}}), {&camera, 1}, fresh_picture));
  EXPECT_EQ(kept_picture.at(0).pixels, fresh_picture.at(0).pixels);
}

// A device that is lost after two pictures.
class LostRenderer final : public SplatRenderer {
 public:
  const std::string& name() const override { return name_; }
  const RenderTimes& last_times() const override { return times_; }
  Result<void> draw(std::span<const RenderedObject> objects, std::span<const Camera> eyes,
                    const RenderOptions& options, std::vector<Image>& images) override {
    if (++drawn_ > 2) return Error{ErrorCode::Unavailable, "vulkan: vkQueueSubmit2 failed with VkResult -4"};
    return create_cpu_renderer()->draw(objects, eyes, options, images);
  }

 private:
  std::string name_ = "lost";
  RenderTimes times_;
  int drawn_ = 0;
};

TEST(SceneView, CpuReplacesLostDevice) {
  const Camera camera = look_at({0, 0, 2}, {0, 0, 0}, {0, 1, 0}, 0.7, 96, 64);
  SceneView view(std::make_unique<LostRenderer>());
  ASSERT_TRUE(view.add(1, cube_asset(0.3f, {1, 0, 0}), rigid_rest(), false));
  std::vector<Image> first, picture;
  ASSERT_TRUE(view.draw(frame_of({{1, {0, 0, 0}}}), {&camera, 1}, first));
  EXPECT_EQ(view.renderer_name(), "lost");
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(view.draw(frame_of({{1, {0, 0, 0}}}), {&camera, 1}, picture));
    EXPECT_EQ(picture.at(0).pixels, first.at(0).pixels);
  }
  EXPECT_EQ(view.renderer_name(), "cpu");
  EXPECT_EQ(view.notice(),
            "lost: rendering continues on the CPU (vulkan: vkQueueSubmit2 failed with VkResult -4)");
}

// For a headset: if a renderer cannot draw into device images, pictures come from the same renderer or the
// CPU.
TEST(SceneView, FallsBackToImagesWithoutDeviceImage) {
  const Camera camera = look_at({0, 0, 2}, {0, 0, 0}, {0, 1, 0}, 0.7, 96, 64);
  SceneView view(std::make_unique<LostRenderer>());
  ASSERT_TRUE(view.add(1, cube_asset(0.3f, {1, 0, 0}), rigid_rest(), false));
  std::vector<Image> first, picture, again;
  ASSERT_TRUE(view.draw(frame_of({{1, {0, 0, 0}}}), {&camera, 1}, first));
  for (const char* renderer : {"lost", "cpu"}) {
    ASSERT_TRUE(view.draw_into(frame_of({{1, {0, 0, 0}}}), {&camera, 1}, DeviceImage{}, picture));
    EXPECT_EQ(view.renderer_name(), renderer);
    EXPECT_EQ(picture.at(0).pixels, first.at(0).pixels);
  }
  const auto oracle = create_cpu_renderer();
  ASSERT_TRUE(view.draw_again(*oracle, {&camera, 1}, again));
  EXPECT_EQ(again.at(0).pixels, first.at(0).pixels);
}

// Records the options a renderer receives.
class AskedRenderer final : public SplatRenderer {
 public:
  const std::string& name() const override { return name_; }
  const RenderTimes& last_times() const override { return times_; }
  Result<void> draw(std::span<const RenderedObject>, std::span<const Camera>, const RenderOptions& options,
                    std::vector<Image>&) override {
    asked = options;
    return {};
  }
  RenderOptions asked;

 private:
  std::string name_ = "asked";
  RenderTimes times_;
};

TEST(SceneView, RadiusLimitShrinksWhilePicturesAreLate) {
  const Camera camera = look_at({0, 0, 2}, {0, 0, 0}, {0, 1, 0}, 0.7, 96, 64);
  auto made = std::make_unique<AskedRenderer>();
  const RenderOptions& asked = made->asked;
  SceneView view(std::move(made));
  std::vector<Image> picture;
  ASSERT_TRUE(view.draw({}, {&camera, 1}, picture));
  EXPECT_EQ(asked.max_radius_px, 192);
  view.set_min_contribution(0.5f);
  ASSERT_TRUE(view.draw({}, {&camera, 1}, picture));
  EXPECT_EQ(asked.max_radius_px, 96);
  EXPECT_EQ(asked.min_contribution_px, 0.5f);
  AskedRenderer again;  // reference pictures use the same options
  ASSERT_TRUE(view.draw_again(again, {&camera, 1}, picture));
  EXPECT_EQ(again.asked.max_radius_px, 96);
  EXPECT_EQ(again.asked.min_contribution_px, 0.5f);
}

// Red is 26 degrees to the left of blue and 7 % farther away: along the view axis it is nearer until the head
// turns to it. With two eyes blue stays in front of red.
TEST(SceneView, DepthOrderIsInvariantToHeadRotation) {
  const auto wide_kernel = [](const Eigen::Vector3f& dc) {
    auto asset = std::make_shared<GaussianAsset>();
    asset->resize(1);
    asset->positions[0].setZero();
    asset->log_scales[0].setConstant(std::log(0.3f));
    asset->rotations[0].setIdentity();
    asset->opacity_logits[0] = 2.0f;  // opacity 0.88
    asset->sh_dc[0] = dc;
    return asset;
  };
  SceneView view;
  ASSERT_TRUE(view.add(1, wide_kernel({1.5f, -1.5f, -1.5f}), rigid_rest(), false));
  ASSERT_TRUE(view.add(2, wide_kernel({-1.5f, -1.5f, 1.5f}), rigid_rest(), false));
  const DriverFrame frame = frame_of({{1, {-0.5, 0, -1}}, {2, {0, 0, -1.05}}});
  const Eigen::Vector3d between = Eigen::Vector3d(-0.25, 0, -1.02);
  for (const double turned_rad : {0.0, 0.2, 0.46}) {
    const Pose head{{0, 0, 0}, Eigen::Quaterniond(Eigen::AngleAxisd(turned_rad, Eigen::Vector3d::UnitY()))};
    std::vector<Camera> eyes;
    for (const double side_m : {-0.032, 0.032})
      eyes.push_back(camera_from_fov(head * Pose{{side_m, 0, 0}, Eigen::Quaterniond::Identity()}, -0.8, 0.8,
                                     0.8, -0.8, 96, 96));
    std::vector<Image> pictures, middle;
    ASSERT_TRUE(view.draw(frame, eyes, pictures));
    const auto blue_over_red = [&](const Image& picture, const Camera& eye) {
      const Eigen::Vector3d at = eye.world_from_camera.inverse() * between;
      const float* pixel = picture.at(static_cast<int>(eye.centre_x_px - eye.focal_x_px * at.x() / at.z()),
                                      static_cast<int>(eye.centre_y_px + eye.focal_y_px * at.y() / at.z()));
      return pixel[2] / pixel[0];
    };
    for (size_t e = 0; e < 2; ++e)
      EXPECT_GT(blue_over_red(pictures.at(e), eyes[e]), 1.5f) << e << " turned by " << turned_rad;
    // One eye uses depth order, as in training.
    const Camera one = camera_from_fov(head, -0.8, 0.8, 0.8, -0.8, 96, 96);
    ASSERT_TRUE(view.draw(frame, {&one, 1}, middle));
    if (turned_rad == 0) {
      EXPECT_LT(blue_over_red(middle.at(0), one), 1 / 1.5f);
    }
  }
}

TEST(SceneView, SkipsRemovedAndUnknownObjects) {
  SceneView view;
  ASSERT_TRUE(view.add(1, cube_asset(0.2f, {1, 0, 0}), rigid_rest(), false));
  ASSERT_TRUE(view.add(2, cube_asset(0.2f, {0, 1, 0}), rigid_rest(), false));
  view.remove(2);
  ASSERT_TRUE(view.pose(frame_of({{1, {0, 0, 0}}, {2, {5, 0, 0}}, {3, {9, 0, 0}}})));
  ASSERT_EQ(view.object_boxes().size(), 1u);
  EXPECT_NEAR(view.object_boxes()[0].max().x(), 0.1, 0.02);
}

TEST(SceneView, MismatchedDriversAreRefused) {
  SceneView view;
  ASSERT_TRUE(view.add(1, cube_asset(0.2f, {1, 0, 0}), rigid_rest(), false));
  DriverFrame frame = frame_of({{1, {0, 0, 0}}});
  frame.objects[0].poses.push_back(Pose{});
  const auto posed = view.pose(frame);
  ASSERT_FALSE(posed);
  EXPECT_NE(posed.error().message.find("object 1"), std::string::npos) << posed.error().message;
}

// An object fractures: the event comes first, and frames of the earlier revision may follow.
TEST(SceneView, EarlierRevisionIsDrawnUntilNewFrame) {
  SceneView view;
  ASSERT_TRUE(view.add(1, cube_asset(0.2f, {1, 0, 0}), rigid_rest(), false));
  const DriverFrame whole = frame_of({{1, {3, 0, 0}}});
  RestBody broken = rigid_rest();
  broken.revision = 1;
  broken.bodies.push_back({{0.05, 0, 0}, Eigen::Quaterniond::Identity()});
  broken.kernel_runs = {{0, 256}, {1, 256}};
  ASSERT_TRUE(view.change(1, cube_asset(0.2f, {1, 0, 0}), broken, false));
  ASSERT_TRUE(view.pose(whole));
  EXPECT_NEAR(view.bounds(1).center().x(), 3.0, 1e-6);
  DriverFrame apart = frame_of({{1, {0, 0, 0}}});
  apart.objects[0].revision = 1;
  apart.objects[0].poses.push_back({{7, 0, 0}, Eigen::Quaterniond::Identity()});
  ASSERT_TRUE(view.pose(apart));
  EXPECT_NEAR(view.bounds(1).max().x(), 7.0, 0.2);
  // Drivers of a removed revision are refused with a reason.
  const auto late = view.pose(whole);
  ASSERT_FALSE(late);
  EXPECT_NE(late.error().message.find("revision 0"), std::string::npos) << late.error().message;
  broken.revision = 2;
  broken.kernel_runs = {{0, 1}};
  const auto refused = view.change(1, cube_asset(0.2f, {1, 0, 0}), broken, false);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("object 1"), std::string::npos) << refused.error().message;
}

// The default camera depends on all corners of the objects and not on the extent of the environment.
TEST(ChooseCamera, ShowsAllObjectsBeforeEnvironment) {
  SceneView view;
  ASSERT_TRUE(view.add(1, cube_asset(8.0f, {0, 0, 1}), rigid_rest(), true));
  ASSERT_TRUE(view.add(2, cube_asset(0.4f, {1, 0, 0}), rigid_rest(), false));
  ASSERT_TRUE(view.add(3, cube_asset(0.4f, {0, 1, 0}), rigid_rest(), false));
  ASSERT_TRUE(view.pose(frame_of({{1, {-3, 0, 0}}, {2, {-0.5, 0.2, 0}}, {3, {0.5, 0.2, 0}}})));
  const Camera camera = choose_camera(view, 320, 240);
  double nearest_edge = 1;
  for (const Eigen::AlignedBox3d& box : view.object_boxes()) {
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d seen = camera.world_from_camera.inverse() *
                                   box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
      ASSERT_LT(seen.z(), 0);
      const double x = std::abs(seen.x() / seen.z() * camera.focal_x_px) / 160;
      const double y = std::abs(seen.y() / seen.z() * camera.focal_y_px) / 120;
      EXPECT_LT(std::max(x, y), 0.9 + 1e-9);
      nearest_edge = std::min({nearest_edge, 0.9 - x, 0.9 - y});
    }
  }
  EXPECT_NEAR(nearest_edge, 0.0, 1e-9);                     // and a nearer camera is impossible
  EXPECT_GT(camera.world_from_camera.position_m.x(), 0.5);  // the environment's centre is at x = -3
  EXPECT_GT(camera.world_from_camera.position_m.y(), 0.4);
}

// 10 % of the columns' half width is margin; the objects reach both edges of the rest.
TEST(ChooseCamera, ShowsAllObjectsInFreeColumns) {
  SceneView view;
  ASSERT_TRUE(view.add(2, cube_asset(0.4f, {1, 0, 0}), rigid_rest(), false));
  ASSERT_TRUE(view.add(3, cube_asset(0.4f, {0, 1, 0}), rigid_rest(), false));
  ASSERT_TRUE(view.pose(frame_of({{2, {-0.9, 0.2, 0.3}}, {3, {0.9, 0.2, 0}}})));
  for (const PictureColumns free :
       {PictureColumns{310, 880}, PictureColumns{310, 1280}, PictureColumns{0, 300}}) {
    SCOPED_TRACE(free.left_px);
    const Camera camera = choose_camera(view, 1280, 800, free);
    double left = 1280, right = 0;
    for (const Eigen::AlignedBox3d& box : view.object_boxes()) {
      for (int corner = 0; corner < 8; ++corner) {
        const Eigen::Vector3d seen = camera.world_from_camera.inverse() *
                                     box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
        ASSERT_LT(seen.z(), 0);
        const double x = camera.centre_x_px - seen.x() / seen.z() * camera.focal_x_px;
        left = std::min(left, x);
        right = std::max(right, x);
        EXPECT_LT(std::abs(seen.y() / seen.z() * camera.focal_y_px), 400);
      }
    }
    const double room = 0.05 * (free.right_px - free.left_px);
    EXPECT_NEAR(left, free.left_px + room, 1e-6);
    EXPECT_NEAR(right, free.right_px - room, 1e-6);
  }
}

}  // namespace
}  // namespace livegs
