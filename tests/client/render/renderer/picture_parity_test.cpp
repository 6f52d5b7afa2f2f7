// SPDX-License-Identifier: Apache-2.0
// Pictures of the device compared with the reference renderer.
#include "client/render/renderer/posed_assets.h"
#include "client/render/renderer/renderer_fixture.h"
#include "sample/sample_scene.h"

namespace livegs {
namespace {

using synthetic::Object;

class PictureParity : public PicturesByMethod {};
INSTANTIATE_TEST_SUITE_P(Method, PictureParity, kBothMethods, method_name);

const RenderOptions kGrey{.background = {0.4f, 0.45f, 0.5f}};

std::array<Camera, 2> headset(const Pose& head, int width, int height) {
  std::array<Camera, 2> eyes;
  for (int e = 0; e < 2; ++e) {
    const double side = e == 0 ? -1.0 : 1.0;
    const Pose eye = head * Pose{{side * 0.032, 0, 0}, Eigen::Quaterniond::Identity()};
    eyes[e] = camera_from_fov(eye, e == 0 ? -0.9 : -0.7, e == 0 ? 0.7 : 0.9, 0.75, -0.85, width, height);
  }
  return eyes;
}

TEST_P(PictureParity, SampleAssetsMatchFromAllSidesAndDeformed) {
  for (const auto& [name, make] : {std::pair<const char*, GaussianAsset (*)(uint64_t)>{"cup", make_cup},

                                   {"duck", make_toy_duck}}) {
    const GaussianAsset asset = make(1);
    for (const double twist : {0.0, 1.5}) {
      const PosedKernels kernels = pose_asset(asset, twist);
      const RenderedObject object = rendered({&asset, &kernels, 0}, ++version_);
      for (const View view : {View::Front, View::Close, View::Inside}) {
        if (twist > 0 && view != View::Front) continue;
        const Camera eye = view_of(extent_of(kernels), view, 160, 120);
        const auto made = draw({&object, 1}, {&eye, 1}, kGrey);
        const auto expected = oracle({&object, 1}, {&eye, 1}, kGrey);
        const double db = psnr_db(made[0], expected[0]);
        RecordProperty(std::string(name) + (twist > 0 ? "_deformed_" : "_") + name_of(view),
                       std::to_string(db));
        EXPECT_GE(db, kBar_db) << name << (twist > 0 ? " deformed " : " ") << name_of(view);
      }
    }
  }
}

TEST_P(PictureParity, EveryHarmonicsDegreeMatches) {
  for (int degree = 0; degree <= 3; ++degree) {
    const Object object = synthetic::shell(2000, degree, 0.02, 7 + degree);
    const Camera eye = look_at({0.2, 0.3, 1.4}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.8, 160, 120);
    EXPECT_GE(psnr_db(draw(object, eye), oracle(object, eye)), kBar_db) << degree;
  }
}

// Blended in 32-bit floats and read before quantisation, the remaining error is float arithmetic and
// half-float bands: 2^-12 of each of 15 bands of 0.1, at least 80 dB.
TEST_P(PictureParity, FullPrecisionReaches80Decibels) {
  make_method({.precision = BlendPrecision::Full, .read_blended = true});
  const Object object = synthetic::shell(4000, 3, 0.015, 11);
  for (const double distance_m : {1.5, 0.7, 0.1}) {
    const Camera eye =
        look_at({0, 0.1, distance_m}, {0, 0, distance_m - 1}, Eigen::Vector3d::UnitY(), 0.9, 160, 120);
    const RenderedObject one = rendered(object.drawn());
    std::vector<Image> expected;  // not limited to 1
    ASSERT_TRUE(create_cpu_renderer()->draw({&one, 1}, {&eye, 1}, {}, expected));
    EXPECT_GE(psnr_db(draw(object, eye), expected[0]), 80.0) << distance_m;
  }
}

// Parallel eyes have the same depth order, so one sort is exact for both. Distance from the point between the
// eyes, used for headsets, gives one order for any two eyes, here 6 degrees apart.
TEST_P(PictureParity, BothEyesMatchWithOneSort) {
  const Object object = synthetic::shell(4000, 3, 0.02, 12);
  const RenderedObject one = rendered(object.drawn());
  for (const double distance_m : {1.2, 0.75}) {
    const Eigen::Quaterniond turned(Eigen::AngleAxisd(0.2, Eigen::Vector3d(1, 1, 0).normalized()));
    const auto eyes = headset({{0, 0.1, distance_m}, turned}, 144, 160);
    const auto made = draw({&one, 1}, eyes, kGrey);
    const auto expected = oracle({&one, 1}, eyes, kGrey);
    ASSERT_EQ(made.size(), 2u);
    for (int e = 0; e < 2; ++e) EXPECT_GE(psnr_db(made[e], expected[e]), kBar_db) << e << " " << distance_m;
    EXPECT_LT(psnr_db(made[0], made[1]), 30.0);  // and the two pictures differ
    RenderOptions by_distance = kGrey;
    by_distance.order = DepthOrder::Distance;
    auto apart = eyes;
    for (int e = 0; e < 2; ++e) {
      Pose& eye = apart[e].world_from_camera;
      eye.orientation = eye.orientation * Eigen::AngleAxisd(e == 0 ? 0.05 : -0.05, Eigen::Vector3d::UnitY());
    }
    const auto made_apart = draw({&one, 1}, apart, by_distance);
    const auto expected_apart = oracle({&one, 1}, apart, by_distance);
    ASSERT_EQ(made_apart.size(), 2u);
    for (int e = 0; e < 2; ++e)
      EXPECT_GE(psnr_db(made_apart[e], expected_apart[e]), kBar_db) << e << " " << distance_m;
  }
}

// The right eye sees a near kernel further to the left, by focal length times eye distance over depth.
TEST_P(PictureParity, ParallaxHasExpectedSignAndSize) {
  Object object;
  synthetic::add_ball(object, {0, 0, 0}, 0.01, 0.9, {1, 1, 1});
  const RenderedObject one = rendered(object.drawn());
  std::array<Camera, 2> eyes;
  for (int e = 0; e < 2; ++e) {
    eyes[e] = camera_from_fov({{e == 0 ? -0.032 : 0.032, 0, 0.8}, Eigen::Quaterniond::Identity()}, -0.5, 0.5,
                              0.5, -0.5, 200, 200);
  }
  const auto made = draw({&one, 1}, eyes);
  double centre[2];
  for (int e = 0; e < 2; ++e) {
    double sum = 0, weighted = 0;
    for (int y = 0; y < 200; ++y) {
      for (int x = 0; x < 200; ++x) {
        const double alpha = made[e].at(x, y)[3];
        sum += alpha;
        weighted += alpha * (x + 0.5);
      }
    }
    centre[e] = weighted / sum;
  }
  EXPECT_NEAR(centre[0] - centre[1], eyes[0].focal_x_px * 0.064 / 0.8,
              0.05);  // 8 bits of alpha over some 60 pixels
}

TEST_P(PictureParity, ObjectOrderDoesNotMatter) {
  const Object first = synthetic::shell(1500, 1, 0.03, 13);
  Object second =
      synthetic::moved(synthetic::shell(1500, 2, 0.03, 14), {{0.2, 0, 0.1}, Eigen::Quaterniond::Identity()});
  second.id = 1;
  const Camera eye = look_at({0.2, 0.3, 1.6}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.8, 160, 120);
  const std::array there{rendered(first.drawn()), rendered(second.drawn())};
  const std::array back{there[1], there[0]};
  const auto made = draw(there, {&eye, 1});
  EXPECT_GE(psnr_db(made[0], oracle(there, {&eye, 1})[0]), kBar_db);
  EXPECT_EQ(made[0].pixels, draw(back, {&eye, 1})[0].pixels);
}

// Cached data between pictures: moved objects are posed again, removed ones are not drawn, and other sizes
// and eye counts are supported.
TEST_P(PictureParity, PictureIsIndependentOfPreviousPicture) {
  const Object still = synthetic::shell(800, 1, 0.04, 15);
  Object moving = synthetic::shell(700, 0, 0.04, 16);
  moving.id = 5;
  const Object moved = synthetic::moved(moving, {{0.3, 0.1, 0}, Eigen::Quaterniond::Identity()});
  const Camera eye = look_at({0.1, 0.2, 1.6}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.8, 120, 90);
  Camera larger = eye;
  larger.width = 150;
  const auto both = headset({{0, 0, 1.5}, Eigen::Quaterniond::Identity()}, 96, 96);
  const std::vector<std::vector<RenderedObject>> frames{{rendered(still.drawn(), 1), {moving.drawn(), 2, 2}},
                                                        {rendered(still.drawn(), 1), {moved.drawn(), 3, 2}},
                                                        {rendered(still.drawn(), 1)},
                                                        {},
                                                        {{moved.drawn(), 3, 2}, rendered(still.drawn(), 1)}};
  for (size_t i = 0; i < frames.size(); ++i) {
    for (const std::span<const Camera> eyes :
         {std::span<const Camera>(&eye, 1), std::span<const Camera>(both),
          std::span<const Camera>(&larger, 1)}) {
      const auto made = draw(frames[i], eyes, kGrey);
      const auto expected = oracle(frames[i], eyes, kGrey);
      for (size_t e = 0; e < eyes.size(); ++e)
        EXPECT_GE(psnr_db(made[e], expected[e]), kBar_db) << i << " " << e;
    }
  }
}

TEST_P(PictureParity, RepeatedPictureIsBitIdentical) {
  const Object object = synthetic::shell(3000, 2, 0.03, 17);
  const Camera eye = look_at({0.1, 0.2, 1.2}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.8, 160, 120);
  const Image first = draw(object, eye);
  EXPECT_EQ(draw(object, eye).pixels, first.pixels);
}

}  // namespace
}  // namespace livegs
