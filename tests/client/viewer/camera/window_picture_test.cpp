// SPDX-License-Identifier: Apache-2.0
#include "viewer/camera/window_picture.h"

#include <gtest/gtest.h>

#include <cmath>

#include "gaussian/gaussian_asset.h"

namespace livegs {
namespace {

constexpr double kTight_ms = 1e-6;  // every picture is late
constexpr int64_t kInterval_ns = 20'000'000;
const Eigen::Vector2i kWindow(160, 120);

struct Spiral {
  Spiral() : camera(look_at({0, 0.2, 1.5}, {0, 0, 0}, {0, 1, 0}, 0.7, kWindow.x(), kWindow.y()), 1.5) {
    auto asset = std::make_shared<GaussianAsset>();
    asset->resize(2000);
    for (size_t i = 0; i < asset->size(); ++i) {  // a spiral of small kernels, many of which are culled
      const auto t = static_cast<float>(i) / static_cast<float>(asset->size());
      asset->positions[i] = {0.4f * std::cos(60 * t), 0.8f * t - 0.4f, 0.4f * std::sin(60 * t)};
      asset->log_scales[i].setConstant(std::log(0.004f));
      asset->rotations[i].setIdentity();
      asset->opacity_logits[i] = 2;
      asset->sh_dc[i] = {std::sin(9 * t), std::cos(7 * t), 1 - t};
    }
    RestBody rest;
    rest.bodies = {Pose{}};
    EXPECT_TRUE(view.add(1, asset, rest, false));
    pose(0);
  }
  void pose(double x_m) {
    ObjectDrivers drivers;
    drivers.object_id = 1;
    drivers.poses = {{{x_m, 0, 0}, Eigen::Quaterniond::Identity()}};
    DriverFrame frame;
    frame.objects = {drivers};
    EXPECT_TRUE(view.pose(frame));
  }
  // The reference picture of the window at full size.
  Image reference() {
    const auto renderer = create_cpu_renderer();
    const Camera eye = camera.camera(kWindow.x(), kWindow.y());
    view.set_min_contribution(0);
    std::vector<Image> images;
    EXPECT_TRUE(view.draw_again(*renderer, {&eye, 1}, images));
    return images[0];
  }
  SceneView view;
  OrbitCamera camera;
};

TEST(WindowPicture, RestsAtTheReferencePicture) {
  Spiral scene;
  WindowPicture picture(kTight_ms);
  int64_t now_ns = 0;
  const auto draw = [&] {
    now_ns += kInterval_ns;
    ASSERT_TRUE(picture.draw(scene.view, scene.camera, kWindow, now_ns));
  };
  for (int i = 0; i < 20; ++i) {  // it moves: pictures are reduced to a quarter
    scene.pose(0.001 * i);
    draw();
    ASSERT_EQ(picture.drawn().size(), 1u);
    EXPECT_FALSE(picture.rests());
  }
  EXPECT_EQ(picture.drawn()[0].width, kWindow.x() / 4);
  int pictures = 0;
  for (int i = 0; i < 50; ++i) {
    draw();
    if (picture.drawn().empty()) continue;
    ++pictures;
    EXPECT_EQ(picture.drawn()[0].width, kWindow.x());
    EXPECT_EQ(picture.drawn()[0].height, kWindow.y());
    EXPECT_EQ(picture.drawn()[0].pixels, scene.reference().pixels);
  }
  EXPECT_EQ(pictures, 1);
  EXPECT_TRUE(picture.rests());
  EXPECT_EQ(picture.text(), "resolution 100 %, at rest");
  // Any movement draws reduced pictures again.
  scene.camera.zoom(1);
  draw();
  ASSERT_EQ(picture.drawn().size(), 1u);
  EXPECT_EQ(picture.drawn()[0].width, kWindow.x() / 4);
  EXPECT_FALSE(picture.rests());
}

TEST(WindowPicture, PicturesOnTimeAreDrawnOnce) {
  Spiral scene;
  WindowPicture picture(kUnlimitedBudget_ms);
  int pictures = 0;
  for (int64_t now_ns = 0; now_ns < 50 * kInterval_ns; now_ns += kInterval_ns) {
    ASSERT_TRUE(picture.draw(scene.view, scene.camera, kWindow, now_ns));
    if (picture.drawn().empty()) continue;
    ++pictures;
    EXPECT_EQ(picture.drawn()[0].pixels, scene.reference().pixels);
  }
  EXPECT_EQ(pictures, 1);
  picture.reset();
  ASSERT_TRUE(picture.draw(scene.view, scene.camera, kWindow, 51 * kInterval_ns));
  EXPECT_EQ(picture.drawn().size(), 1u);
}

}  // namespace
}  // namespace livegs
