// SPDX-License-Identifier: Apache-2.0
// Images with values known in closed form.
#include "splat/rasterise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/splat/synthetic_kernels.h"
#include "core/parallel_for.h"

namespace livegs {
namespace {

using synthetic::Object;

constexpr double kFocal_px = 500.0;
constexpr double kLowPass_px2 = 0.3;
// Floats of order 1 after a dozen roundings and an exponential accurate to 4e-7.
constexpr double kRounding = 3e-6;

// Looks along -z from the origin; the axis passes through the centre of pixel (64, 48).
Camera straight_ahead(double near_m = 0.05) {
  Camera camera;
  camera.width = 128;
  camera.height = 96;
  camera.focal_x_px = camera.focal_y_px = kFocal_px;
  camera.centre_x_px = 64.5;
  camera.centre_y_px = 48.5;
  camera.near_m = near_m;
  return camera;
}

// The world standard deviation with a projected size of `shown_px` after the low-pass, on the axis.
double deviation_for(double shown_px, double depth_m) {
  return std::sqrt(shown_px * shown_px - kLowPass_px2) * depth_m / kFocal_px;
}

RasterisedView draw(const Object& object, const Camera& camera, const RasteriseOptions& options = {}) {
  const DrawnObject drawn = object.drawn();
  RasterisedView view;
  Rasteriser().draw({&drawn, 1}, camera, options, view);
  return view;
}

TEST(Rasterise, AGaussianHasItsClosedFormValues) {
  Object object;
  synthetic::add_ball(object, {0, 0, -2}, deviation_for(4.0, 2.0), 0.8, {0.75, 0.5, 0.25});
  const RasterisedView view = draw(object, straight_ahead());
  const auto expect_alpha = [&](int x, int y, double alpha) {
    const float* rgba = view.image.at(x, y);
    EXPECT_NEAR(rgba[0], 0.75 * alpha, kRounding);
    EXPECT_NEAR(rgba[1], 0.50 * alpha, kRounding);
    EXPECT_NEAR(rgba[2], 0.25 * alpha, kRounding);
    EXPECT_NEAR(rgba[3], alpha, kRounding);
  };
  expect_alpha(64, 48, 0.8);
  for (const auto& [x, y] : {std::pair{4, 0}, {-4, 0}, {0, 4}, {0, -4}}) {
    expect_alpha(64 + x, 48 + y, 0.8 * std::exp(-0.5));
  }
  expect_alpha(64 + 8, 48, 0.8 * std::exp(-2.0));
  expect_alpha(64 + 3, 48 - 4, 0.8 * std::exp(-25.0 / 32.0));
}

TEST(Rasterise, SkipsAlphaBelowOneIn255) {
  Object object;
  synthetic::add_ball(object, {0, 0, -2}, deviation_for(4.0, 2.0), 0.8, {1, 1, 1});
  const RasterisedView view = draw(object, straight_ahead());
  const double rim_px = 4.0 * std::sqrt(2.0 * std::log(255.0 * 0.8));  // 13.05
  EXPECT_GE(view.image.at(64 + static_cast<int>(std::floor(rim_px)), 48)[3], 1.0f / 255.0f);
  EXPECT_EQ(view.image.at(64 + static_cast<int>(std::ceil(rim_px)), 48)[3], 0.0f);
}

TEST(Rasterise, AlphaIsLimitedToTheMaximum) {
  Object object;
  synthetic::add_ball(object, {0, 0, -2}, deviation_for(4.0, 2.0), 0.999, {1, 1, 1});
  EXPECT_NEAR(draw(object, straight_ahead()).image.at(64, 48)[3], 0.99, kRounding);
}

// Blending uses the colours as trained; blending in linear light would give another mix.
TEST(Rasterise, TwoLayersComposeFrontToBack) {
  Object object;
  synthetic::add_ball(object, {0, 0, -3}, 0.5, 0.7, {0.2, 0.9, 0.4});  // given back to front
  synthetic::add_ball(object, {0, 0, -2}, 0.5, 0.6, {0.8, 0.1, 0.3});
  RasteriseOptions options;
  options.background = {0.5f, 0.25f, 1.0f};
  const RasterisedView view = draw(object, straight_ahead(), options);
  const Eigen::Vector3d front(0.8, 0.1, 0.3), back(0.2, 0.9, 0.4), behind(0.5, 0.25, 1.0);
  const Eigen::Vector3d expected = 0.6 * front + 0.4 * 0.7 * back + 0.4 * 0.3 * behind;
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(view.image.at(64, 48)[c], expected[c], kRounding);
  EXPECT_NEAR(view.image.at(64, 48)[3], 1.0 - 0.4 * 0.3, kRounding);
  EXPECT_FLOAT_EQ(view.depth_m[48 * 128 + 64], 2.0f);
}

// Two balls side by side at two depths. By the Jacobian of the projection at its centre, the covariance of a
// ball of deviation s at (x, y, -z) is (f s / z)² [1 + u², u v; u v, 1 + v²] with u = x / z, v = y / z
// (Zwicker et al. 2002, EWA splatting), plus the low-pass on the diagonal.
TEST(Rasterise, OverlappingKernelsMatchTheClosedForm) {
  struct Ball {
    Eigen::Vector3d at_m;
    double deviation_m, opacity;
    Eigen::Vector3d rgb;

    double alpha(double x_px, double y_px) const {
      const double depth_m = -at_m.z(), u = at_m.x() / depth_m,
                   v = -at_m.y() / depth_m;  // rows run downwards
      Eigen::Matrix2d covariance_px2;
      covariance_px2 << 1 + u * u, u * v, u * v, 1 + v * v;
      covariance_px2 *= std::pow(kFocal_px * deviation_m / depth_m, 2);
      covariance_px2.diagonal().array() += kLowPass_px2;
      const Eigen::Vector2d apart(x_px + 0.5 - (64.5 + kFocal_px * u), y_px + 0.5 - (48.5 + kFocal_px * v));
      return opacity * std::exp(-0.5 * apart.dot(covariance_px2.inverse() * apart));
    }
  };
  const Ball front{{0.02, 0.015, -1}, 0.012, 0.6, {0.8, 0.1, 0.3}},
      back{{-0.01, -0.01, -1.5}, 0.03, 0.9, {0.2, 0.9, 0.4}};
  Object object;
  for (const Ball& ball : {back, front})
    synthetic::add_ball(object, ball.at_m, ball.deviation_m, ball.opacity, ball.rgb);
  RasteriseOptions options;
  options.background = {0.5f, 0.25f, 1.0f};
  const Eigen::Vector3d behind(0.5, 0.25, 1.0);
  const RasterisedView view = draw(object, straight_ahead(), options);
  for (const auto& [x, y] : {std::pair{64, 48},
                             {70, 45},
                             {60, 50},
                             {66, 40},
                             {75, 36},
                             {58, 42},
                             {72, 52},
                             {80, 44},
                             {66, 50},
                             {68, 48},
                             {77, 30},
                             {63, 37}}) {
    const double a = front.alpha(x, y), b = back.alpha(x, y);
    ASSERT_GT(std::min(a, b), 1.0 / 255) << x << " " << y;  // both kernels contribute
    const Eigen::Vector3d expected = a * front.rgb + (1 - a) * b * back.rgb + (1 - a) * (1 - b) * behind;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(view.image.at(x, y)[c], expected[c], 1e-4) << x << " " << y;
    EXPECT_NEAR(view.image.at(x, y)[3], 1 - (1 - a) * (1 - b), 1e-4) << x << " " << y;
  }
}

TEST(Rasterise, StopsAtTheMinimumTransmittance) {
  Object object;
  for (int i = 0; i < 4; ++i) synthetic::add_ball(object, {0, 0, -2.0 - 0.1 * i}, 0.5, 0.95, {1, 1, 1});
  // 0.05³ = 1.25e-4 remains after three kernels; the fourth would leave 6e-6 and is not added.
  EXPECT_NEAR(draw(object, straight_ahead()).image.at(64, 48)[3], 1.0 - 1.25e-4, kRounding);
}

TEST(Rasterise, OpacityFadesInNearTheCamera) {
  const auto alpha_at = [](double depth_m) {
    Object object;
    synthetic::add_ball(object, {0, 0, -depth_m}, 0.05, 0.8, {1, 1, 1});
    return draw(object, straight_ahead(0.1)).image.at(64, 48)[3];
  };
  EXPECT_EQ(alpha_at(0.05), 0.0f);
  EXPECT_EQ(alpha_at(0.1), 0.0f);
  EXPECT_NEAR(alpha_at(0.15), 0.2, kRounding);
  EXPECT_NEAR(alpha_at(0.2), 0.4, kRounding);
  EXPECT_NEAR(alpha_at(0.3), 0.8, kRounding);
  EXPECT_NEAR(alpha_at(0.5), 0.8, kRounding);
}

// Mip-Splatting: the low-pass spreads a kernel, so its peak decreases by the ratio of the areas.
TEST(Rasterise, MipTrainedKernelsAreCompensated) {
  const double sharp_px = 0.5, depth_m = 2.0;
  Object object;
  synthetic::add_ball(object, {0, 0, -depth_m}, sharp_px * depth_m / kFocal_px, 0.8, {1, 1, 1});
  EXPECT_NEAR(draw(object, straight_ahead()).image.at(64, 48)[3], 0.8, kRounding);
  object.asset.antialiased = true;
  const double expected = 0.8 * sharp_px * sharp_px / (sharp_px * sharp_px + kLowPass_px2);
  EXPECT_NEAR(draw(object, straight_ahead()).image.at(64, 48)[3], expected, kRounding);
}

TEST(Rasterise, DistanceAndViewOrderDifferOffAxis) {
  // At pixel (64, 48), the green kernel is nearer along the axis but farther from the eye.
  Object object;
  synthetic::add_ball(object, {0.0, 0, -2.0}, 0.3, 0.9, {1, 0, 0});
  synthetic::add_ball(object, {0.7, 0, -1.9}, 0.9, 0.9, {0, 1, 0});
  RasteriseOptions options;
  const RasterisedView by_view_z = draw(object, straight_ahead(), options);
  options.order = DepthOrder::Distance;
  const RasterisedView by_distance = draw(object, straight_ahead(), options);
  EXPECT_GT(by_view_z.image.at(64, 48)[1], by_view_z.image.at(64, 48)[0]);
  EXPECT_GT(by_distance.image.at(64, 48)[0], by_distance.image.at(64, 48)[1]);
}

TEST(Rasterise, KernelsAtEqualDepthKeepTheirOrder) {
  Object object;
  synthetic::add_ball(object, {0, 0, -2}, 0.5, 0.9, {1, 0, 0});
  synthetic::add_ball(object, {0, 0, -2}, 0.5, 0.9, {0, 1, 0});
  const RasterisedView view = draw(object, straight_ahead());
  EXPECT_NEAR(view.image.at(64, 48)[0], 0.9, kRounding);
  EXPECT_NEAR(view.image.at(64, 48)[1], 0.09, kRounding);
}

TEST(Rasterise, InvariantUnderCommonRotation) {
  const Object object = synthetic::shell(3000, 3, 0.02, 5);
  const Camera camera = look_at({0.4, 0.3, 1.4}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.8, 200, 150);
  const Pose motion{{0.3, -0.2, 0.5}, Eigen::Quaterniond(0.4, -0.3, 0.7, 0.5).normalized()};
  Camera moved_camera = camera;
  moved_camera.world_from_camera = motion * camera.world_from_camera;
  const Image before = draw(object, camera).image;
  const Image after = draw(synthetic::moved(object, motion), moved_camera).image;
  size_t different = 0;
  for (size_t i = 0; i < before.pixels.size(); ++i) {
    const float difference = std::abs(before.pixels[i] - after.pixels[i]);
    // One kernel more or less at its threshold, with a colour up to 2.
    EXPECT_LT(difference, 2.0f / 255.0f);
    different += difference > 1e-3f;
  }
  EXPECT_LT(different, before.pixels.size() / 200);
  EXPECT_GT(psnr_db(before, after), 60.0);
}

uint64_t hash_of(const RasterisedView& view) {  // FNV-1a
  uint64_t hash = 0xcbf29ce484222325u;
  const auto add = [&hash](const void* data, size_t size) {
    for (size_t i = 0; i < size; ++i) hash = (hash ^ static_cast<const uint8_t*>(data)[i]) * 0x100000001b3u;
  };
  add(view.image.pixels.data(), 4 * view.image.pixels.size());
  add(view.depth_m.data(), 4 * view.depth_m.size());
  add(view.object_id.data(), 4 * view.object_id.size());
  return hash;
}

TEST(Rasterise, DeterministicForThreadsAndReusedBuffers) {
  Object a = synthetic::shell(20'000, 2, 0.01, 6);
  Object b =
      synthetic::moved(synthetic::shell(15'000, 0, 0.02, 7), {{0.3, 0, 0.1}, Eigen::Quaterniond::Identity()});
  a.id = 4;
  b.id = 9;
  const DrawnObject drawn[] = {a.drawn(), b.drawn()};
  const Camera camera = look_at({0.4, 0.3, 1.4}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.8, 333, 211);
  const Camera elsewhere = look_at({0, 0.3, 0.2}, {0, 0, -1}, Eigen::Vector3d::UnitY(), 1.2, 100, 300);
  Rasteriser rasteriser;
  RasterisedView view;
  set_thread_count(1);
  rasteriser.draw(drawn, camera, {}, view);
  const uint64_t expected = hash_of(view);
  for (const int threads : {1, 2, 4}) {
    set_thread_count(threads);
    rasteriser.draw({drawn, 1}, elsewhere, {}, view);
    rasteriser.draw(drawn, camera, {}, view);
    EXPECT_EQ(hash_of(view), expected) << threads << " threads";
  }
  set_thread_count(0);
}

}  // namespace
}  // namespace livegs
