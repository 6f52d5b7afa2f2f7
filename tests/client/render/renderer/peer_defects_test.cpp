// SPDX-License-Identifier: Apache-2.0
// Defects found in other splat renderers, each with a picture that would reveal it. Defects of files
// (non-unit quaternions, reordered properties, non-finite values) are tested with the readers:
// tests/common/gaussian/asset/invariants_test.cpp and ply_test.cpp. The sort does not depend on subgroup
// sizes (tests/common/splat/passes/key_sorter_test.cpp).
#include <cmath>

#include "client/render/renderer/renderer_fixture.h"

namespace livegs {
namespace {

using synthetic::Object;

class PeerDefects : public VulkanPictures {
 protected:
  // Half a step of 8 bits, plus 2^-11 for 16-bit floats.
  static constexpr double kStep = 0.5 / 255.0 + 0.0005;

  static Camera ahead(int width = 129, int height = 97) {
    return look_at({0, 0, 2}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.8, width, height);
  }
  // Placed at a pixel centre, where alpha equals the opacity.
  static void expect_colour(const Image& image, const Eigen::Vector3d& rgb) {
    const float* pixel = image.at(image.width / 2, image.height / 2);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(pixel[c], rgb[c], kStep) << c;
  }
};

// The clamp follows all bands: a first band far above 1 that the next cancels, and one below 0 that it
// raises.
TEST_F(PeerDefects, ColourIsClampedAfterAllBands) {
  Object object;
  object.asset.sh_degree = 1;
  synthetic::add_ball(object, {0, 0, 0}, 0.3, 0.9, {1.8, -0.6, 0.4});
  const float band = 1.0f / 0.48860251f;  // of z; the view is along -z
  object.asset.sh_rest[1] = {1.2f * band, -1.0f * band, 0.0f};
  expect_colour(draw(object, ahead()), 0.9 * Eigen::Vector3d(0.6, 0.4, 0.4));
  for (int channel = 0; channel < 3; ++channel) {
    Eigen::Vector3d rgb(0.5, 0.5, 0.5), expected(0.45, 0.45, 0.45);
    rgb[channel] = -2.0;
    expected[channel] = 0.0;
    Object dark;
    synthetic::add_ball(dark, {0, 0, 0}, 0.3, 0.9, rgb);
    expect_colour(draw(dark, ahead()), expected);
  }
}

// b == 0 in the projected covariance, with a above, below and equal to d.
TEST_F(PeerDefects, AxisAlignedEllipsesAreDrawn) {
  for (const Eigen::Vector3d& size :
       {Eigen::Vector3d(0.2, 0.02, 0.02), Eigen::Vector3d(0.02, 0.2, 0.02), Eigen::Vector3d(0.1, 0.1, 0.1)}) {
    Object object;
    synthetic::add_kernel(object, {0, 0, 0}, Eigen::Quaterniond::Identity(), size, 0.9, {1, 1, 1});
    const Camera eye = ahead();
    const Image image = draw(object, eye);
    const double f = eye.focal_x_px / 2.0;
    for (int step = 0; step < 40; step += 4) {
      for (const auto& [dx, dy, across] : {std::tuple{step, 0, size.x()}, {0, step, size.y()}}) {
        const double variance = f * f * across * across + 0.3;
        const double alpha = 0.9 * std::exp(-0.5 * step * step / variance);
        EXPECT_NEAR(image.at(64 + dx, 48 + dy)[3], alpha < 1.0 / 255.0 ? 0.0 : alpha, kStep)
            << dx << " " << dy;
      }
    }
  }
}

// At the edge of an asymmetric frustum, the Jacobian is clamped to the slope of that side.
TEST_F(PeerDefects, JacobianIsClampedPerSideOfAsymmetricFrusta) {
  Object object;
  synthetic::Random random(3);
  for (int i = 0; i < 400; ++i) {
    synthetic::add_kernel(object, random.in_ball(0.9), random.rotation(), {0.1, 0.05, 0.01}, 0.8,
                          {random.uniform(), random.uniform(), random.uniform()});
  }
  for (const auto& [left, right] : {std::pair{-1.1, 0.4}, {-0.4, 1.1}}) {
    const Camera eye =
        camera_from_fov({{0, 0, 1.0}, Eigen::Quaterniond::Identity()}, left, right, 0.5, -1.0, 144, 144);
    EXPECT_GE(psnr_db(draw(object, eye), oracle(object, eye)), kBar_db) << left;
  }
}

// White at one half over black is 0.5 encoded; blending in linear light would give 0.73.
TEST_F(PeerDefects, BlendsInTrainingColourSpace) {
  Object object;
  synthetic::add_ball(object, {0, 0, 0}, 0.3, 0.5, {1, 1, 1});
  expect_colour(draw(object, ahead()), {0.5, 0.5, 0.5});
  synthetic::add_ball(object, {0, 0, 0.3}, 0.3, 0.4, {0.2, 0.9, 0.1});  // in front of it
  expect_colour(draw(object, ahead()),
                Eigen::Vector3d(0.2, 0.9, 0.1) * 0.4 + Eigen::Vector3d::Constant(0.6 * 0.5));
  expect_colour(draw(object, ahead(), {.background = {0.0f, 0.5f, 1.0f}}),
                Eigen::Vector3d(0.2, 0.9, 0.1) * 0.4 + Eigen::Vector3d::Constant(0.6 * 0.5) +
                    0.3 * Eigen::Vector3d(0, 0.5, 1));
}

TEST_F(PeerDefects, InvalidKernelsDoNotAffectOthers) {
  Object plain = synthetic::shell(300, 0, 0.05, 5);
  const Image expected = draw(plain, ahead());
  Object object = plain;
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity(), 1e38f}) {
    for (int i = 0; i < 9; ++i) {
      synthetic::add_ball(object, {0, 0, 0}, 0.1, 0.9, {1, 0, 0});
      if (i < 3) object.posed.positions_m.back()[i] = bad;
      if (i >= 3) object.posed.covariances_m2.back()[i - 3] = bad;
    }
  }
  const Image image = draw(object, ahead());
  for (const float value : image.pixels) ASSERT_TRUE(std::isfinite(value) && value >= 0.0f);
  EXPECT_GE(psnr_db(image, expected), kBar_db);
}

TEST_F(PeerDefects, KernelsBeforeNearPlaneAreCulled) {
  Object object;
  synthetic::Random random(3);
  for (int i = 0; i < 300; ++i) {
    synthetic::add_ball(object, random.in_ball(1.0) + Eigen::Vector3d(0, 0, 2.95), random.uniform(0.01, 0.5),
                        0.9, {1, 1, 1});
    if (object.posed.positions_m.back().z() < 1.96f) object.posed.positions_m.back().z() = 1.96f;
  }
  for (const float value : draw(object, ahead()).pixels) ASSERT_EQ(value, 0.0f);
}

// Opacity rises continuously from near_m to three times near_m.
TEST_F(PeerDefects, KernelsFadeNearTheEye) {
  for (const double depth_m : {0.06, 0.08, 0.1, 0.13, 0.16}) {
    Object object;
    synthetic::add_ball(object, {0, 0, 2.0 - depth_m}, 0.02, 0.8, {1, 1, 1});
    const double fade = std::min(1.0, (depth_m - 0.05) / 0.1);
    expect_colour(draw(object, ahead()), Eigen::Vector3d::Constant(0.8 * fade));
  }
}

TEST_F(PeerDefects, KernelLargerThanScreenCoversIt) {
  Object object;
  synthetic::add_ball(object, {0, 0, 0}, 1000.0, 0.8, {1, 1, 1});
  for (const auto& [width, height] : {std::pair{1, 1}, {7, 3}, {17, 33}, {250, 120}}) {
    const Image image = draw(object, ahead(width, height));
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) ASSERT_NEAR(image.at(x, y)[3], 0.8, kStep) << x << " " << y;
    }
  }
}

TEST_F(PeerDefects, NeedleAcrossScreenKeepsItsWidth) {
  Object object;
  for (int i = 0; i < 12; ++i) {
    const Eigen::Quaterniond turned(Eigen::AngleAxisd(0.26 * i, Eigen::Vector3d::UnitZ()));
    synthetic::add_kernel(object, {0.02 * i, 0, 0}, turned, {1.5, 2e-3, 2e-3}, 0.9,
                          {0.9, 0.1 * i, 1 - 0.08 * i});
  }
  const Camera eye = ahead(200, 150);
  EXPECT_GE(psnr_db(draw(object, eye), oracle(object, eye)), kBar_db);
}

// Kernels at equal depth are drawn in index order: the first is in front, in both eyes.
TEST_F(PeerDefects, EqualDepthsKeepTheirOrder) {
  Object object;
  for (const Eigen::Vector3d& rgb :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1)})
    synthetic::add_ball(object, {0, 0, 0}, 0.3, 0.5, rgb);
  expect_colour(draw(object, ahead()), {0.5, 0.25, 0.125});
}

// A model trained with the low-pass filter is dimmed by its area factor; other models are not.
TEST_F(PeerDefects, OnlyAntialiasedModelsAreCompensated) {
  for (const bool antialiased : {false, true}) {
    Object object;
    synthetic::add_ball(object, {0, 0, 0}, 0.004, 0.9, {1, 1, 1});
    object.asset.antialiased = antialiased;
    const Camera eye = ahead();
    const double sharp = std::pow(0.004 * eye.focal_x_px / 2.0, 2);
    expect_colour(draw(object, eye),
                  Eigen::Vector3d::Constant(0.9 * (antialiased ? sharp / (sharp + 0.3) : 1.0)));
  }
}

TEST_F(PeerDefects, HarmonicsRotateWithAsset) {
  Object object;
  object.asset.sh_degree = 1;
  synthetic::add_ball(object, {0, 0, 0}, 0.3, 0.9, {0.5, 0.5, 0.5});
  object.asset.sh_rest[2] = Eigen::Vector3f::Constant(0.4f / 0.48860251f);  // 0.5 - 0.4 x
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.5 * M_PI, Eigen::Vector3d::UnitY()));
  expect_colour(draw(object, ahead()), Eigen::Vector3d::Constant(0.45));
  expect_colour(draw(synthetic::moved(object, {Eigen::Vector3d::Zero(), turn}), ahead()),
                Eigen::Vector3d::Constant(0.09));
}

}  // namespace
}  // namespace livegs
