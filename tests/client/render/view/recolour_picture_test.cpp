// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "client/render/renderer/renderer_fixture.h"
#include "render/scene_view.h"
#include "splat/image.h"

namespace livegs {
namespace {

// A sheet of kernels with view-dependent colour, red or blue by side.
std::shared_ptr<GaussianAsset> sheet_asset() {
  constexpr size_t kSide = 16;
  auto asset = std::make_shared<GaussianAsset>();
  asset->sh_degree = 1;
  asset->resize(kSide * kSide);
  for (size_t i = 0; i < asset->size(); ++i) {
    asset->positions[i] = {0.03f * static_cast<float>(i % kSide) - 0.23f,
                           0.03f * static_cast<float>(i / kSide) - 0.23f, 0};
    asset->log_scales[i].setConstant(std::log(0.015f));
    asset->rotations[i].setIdentity();
    asset->opacity_logits[i] = 2;
    asset->sh_dc[i] = i % kSide < kSide / 2 ? Eigen::Vector3f(1, -1, -1) : Eigen::Vector3f(-1, -1, 1);
    for (size_t k = 0; k < 3; ++k) asset->sh_rest[3 * i + k].setConstant(0.1f * static_cast<float>(k));
  }
  return asset;
}

using RecolouredPictures = PicturesByMethod;

// The copy on the device is replaced, and an object of another degree stays as it is.
TEST_P(RecolouredPictures, DeviceDrawsTheNewColoursAndTheOldOnesAgain) {
  const std::shared_ptr<const GaussianAsset> own = sheet_asset();
  const auto green = sheet_asset();
  green->sh_degree = 0;
  green->sh_rest.clear();
  for (Eigen::Vector3f& dc : green->sh_dc) dc = {-1, 1, -1};
  SceneView device(std::move(renderer_)), reference;
  RestBody rest;
  rest.bodies = {Pose{}};
  DriverFrame frame;
  for (const uint32_t id : {1u, 2u}) {
    for (SceneView* view : {&device, &reference}) ASSERT_TRUE(view->add(id, own, rest, false));
    ObjectDrivers drivers;
    drivers.object_id = id;
    drivers.poses = {{{0.6 * id - 0.9, 0, 0}, Eigen::Quaterniond::Identity()}};
    frame.objects.push_back(drivers);
  }
  const Camera eye = look_at({0, 0.2, 2}, {0, 0, 0}, {0, 1, 0}, 0.5, 160, 96);
  std::vector<Image> first;
  for (const auto& asset : {own, std::shared_ptr<const GaussianAsset>(green), own}) {
    std::array<std::vector<Image>, 2> images;
    const uint64_t version = device.version();
    device.recolour(2, asset);
    reference.recolour(2, asset);
    EXPECT_GT(device.version(), version);
    ASSERT_TRUE(device.draw(frame, {&eye, 1}, images[0]));
    ASSERT_TRUE(reference.draw(frame, {&eye, 1}, images[1]));
    EXPECT_GE(psnr_db(images[0].at(0), images[1].at(0)), 45);
    if (first.empty()) first = images[0];
    if (asset == own)
      EXPECT_EQ(images[0][0].pixels, first[0].pixels);
    else
      EXPECT_LT(psnr_db(images[0][0], first[0]), 25);
  }
}
INSTANTIATE_TEST_SUITE_P(, RecolouredPictures, kBothMethods, method_name);

}  // namespace
}  // namespace livegs
