// SPDX-License-Identifier: Apache-2.0
// A device with limited memory, and its timer.
#include <algorithm>

#include "client/render/renderer/renderer_fixture.h"
#include "render/renderer/most_visible_kernels.h"
#include "render/scene_view.h"

namespace livegs {
namespace {

using synthetic::Object;

TEST(MostVisibleKernels, AreLargeAndOpaque) {
  Object object;
  const Eigen::Quaterniond upright = Eigen::Quaterniond::Identity();
  synthetic::add_kernel(object, {0, 0, 0}, upright, {0.1, 0.1, 0.001}, 0.9, {1, 1, 1});    // 9e-3
  synthetic::add_kernel(object, {0, 0, 0}, upright, {0.1, 0.1, 0.1}, 0.05, {1, 1, 1});     // 5e-4
  synthetic::add_kernel(object, {0, 0, 0}, upright, {0.01, 0.01, 0.01}, 0.99, {1, 1, 1});  // 1e-4
  synthetic::add_kernel(object, {0, 0, 0}, upright, {0.5, 0.002, 0.002}, 0.9, {1, 1, 1});  // 9e-4
  EXPECT_EQ(most_visible_kernels(object.asset, 1), (std::vector<uint32_t>{0}));
  EXPECT_EQ(most_visible_kernels(object.asset, 2), (std::vector<uint32_t>{0, 3}));
  EXPECT_EQ(most_visible_kernels(object.asset, 3), (std::vector<uint32_t>{0, 1, 3}));
  EXPECT_EQ(most_visible_kernels(object.asset, 9), (std::vector<uint32_t>{0, 1, 2, 3}));
}

class DeviceLimits : public PicturesByMethod {
 protected:
  // Creates a renderer on a separate device with this much memory.
  void limit_memory(size_t bytes) {
    renderer_.reset();
    auto device = create_validated_device(shared_vulkan.messages(), bytes);
    ASSERT_TRUE(device) << device.error().message;
    device_ = *std::move(device);
    auto renderer = create_vulkan_renderer(device_, {.method = GetParam()});
    ASSERT_TRUE(renderer) << renderer.error().message;
    renderer_ = *std::move(renderer);
  }
};

INSTANTIATE_TEST_SUITE_P(Method, DeviceLimits, kBothMethods, method_name);

// 40 000 kernels need 212 bytes each and three pictures: 9 MB. With half of that only the largest are drawn,
// with a notice; with fewer kernels all are drawn again.
TEST_P(DeviceLimits, ReducesKernelsWhenMemoryIsExhausted) {
  const Object many = synthetic::shell(40'000, 3, 0.006, 3);
  Object few = synthetic::shell(2'000, 1, 0.02, 4);
  few.id = 2;
  const Camera eye = look_at({0.2, 0.3, 1.4}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.8, 160, 120);
  const RenderedObject both[] = {rendered(many.drawn(), 1), rendered(few.drawn(), 2)};
  const Image whole = draw(both, {&eye, 1})[0];
  EXPECT_EQ(renderer_->notice(), "");
  limit_memory(5'000'000);
  const Image thinned = draw(both, {&eye, 1})[0];
  EXPECT_NE(renderer_->notice().find("% of the kernels; the rest is not drawn"), std::string::npos)
      << renderer_->notice();
  EXPECT_GT(psnr_db(thinned, whole), 20.0);  // an empty picture would have 11 dB
  EXPECT_LT(psnr_db(thinned, whole), 60.0);  // the pictures differ
  EXPECT_EQ(draw(both, {&eye, 1})[0].pixels, thinned.pixels);
  // A moved object is drawn at its new position.
  const Object moved = synthetic::moved(many, {{0.1, 0, 0}, Eigen::Quaterniond::Identity()});
  const RenderedObject after[] = {{moved.drawn(), 3, 1}, both[1]};
  EXPECT_GT(psnr_db(draw(after, {&eye, 1})[0], oracle(after, {&eye, 1})[0]), 20.0);
  const Image alone = draw({&both[1], 1}, {&eye, 1})[0];
  EXPECT_EQ(renderer_->notice(), "");
  EXPECT_GT(psnr_db(alone, oracle({&both[1], 1}, {&eye, 1})[0]), kBar_db);
}

// If too few kernels fit, the CPU draws all of them, with a notice.
TEST_P(DeviceLimits, FallsBackToCpuWithoutMemory) {
  limit_memory(100'000);
  const std::string device = renderer_->name();
  const Object many = synthetic::shell(4'000, 3, 0.02, 3);
  RestBody rest;
  rest.bodies = {Pose{}};
  DriverFrame frame;
  frame.objects.emplace_back();
  frame.objects[0].object_id = 1;
  frame.objects[0].poses = {Pose{}};
  const Camera eye = look_at({0.2, 0.3, 1.4}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.8, 160, 120);
  SceneView cramped(std::move(renderer_)), roomy;
  std::vector<Image> picture, expected;
  for (SceneView* view : {&cramped, &roomy})
    ASSERT_TRUE(view->add(1, std::make_shared<GaussianAsset>(many.asset), rest, false));
  ASSERT_TRUE(cramped.draw(frame, {&eye, 1}, picture));
  ASSERT_TRUE(roomy.draw(frame, {&eye, 1}, expected));
  EXPECT_EQ(picture.at(0).pixels, expected.at(0).pixels);
  EXPECT_EQ(cramped.renderer_name(), "cpu");
  EXPECT_EQ(cramped.notice().rfind(device + ": rendering continues on the CPU (", 0), 0u) << cramped.notice();
  EXPECT_NE(cramped.notice().find("out of memory"), std::string::npos) << cramped.notice();
  EXPECT_EQ(roomy.notice(), "");
}

TEST_P(DeviceLimits, NoMemoryIsAnErrorForTheRenderer) {
  limit_memory(100'000);
  const Object many = synthetic::shell(4'000, 3, 0.02, 3);
  const Camera eye = look_at({0.2, 0.3, 1.4}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.8, 160, 120);
  const RenderedObject one = rendered(many.drawn());
  std::vector<Image> images;
  const auto done = renderer_->draw({&one, 1}, {&eye, 1}, {}, images);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, ErrorCode::TooLarge);
}

// Projected rows may be split over several buffers: the result is bit-identical for all objects and both
// eyes. Beyond the limit fewer are drawn, with a notice that does not mention memory.
TEST_P(DeviceLimits, SplitBuffersGiveSamePicture) {
  const Object shell = synthetic::shell(2'500, 3, 0.02, 3);
  Object other = synthetic::shell(400, 1, 0.02, 4);
  other.id = 2;
  const Camera eye = look_at({0.2, 0.3, 1.4}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.8, 160, 120);
  Camera right = eye;
  right.world_from_camera.position_m.x() += 0.064;
  const Camera eyes[] = {eye, right};
  const RenderedObject both[] = {rendered(shell.drawn()), rendered(other.drawn())};
  const auto whole = draw(both, eyes);
  make_method({.precision = BlendPrecision::Half, .max_part_rows = 1000});
  const auto parted = draw(both, eyes);
  ASSERT_EQ(parted.size(), 2u);
  for (int e = 0; e < 2; ++e) EXPECT_EQ(parted[e].pixels, whole[e].pixels) << e;
  EXPECT_EQ(renderer_->notice(), "");
  EXPECT_EQ(draw({both, 1}, {&eye, 1})[0].pixels.size(), whole[0].pixels.size());

  const Object many = synthetic::shell(4'000, 3, 0.02, 3);
  const RenderedObject more = rendered(many.drawn(), 3);
  const Image fewer = draw({&more, 1}, {&eye, 1})[0];
  EXPECT_EQ(renderer_->notice(),
            "bindable buffers of " + device_->name() + " hold 75 % of the kernels; the rest is not drawn");
  EXPECT_GT(psnr_db(fewer, oracle({&more, 1}, {&eye, 1})[0]), 20.0);  // an empty picture would have 11 dB
  EXPECT_EQ(draw({&both[1], 1}, {&eye, 1}).size(), 1u);
  EXPECT_EQ(renderer_->notice(), "");
}

// Device time of each pass is at most the host's wait; lavapipe has a timer.
TEST_P(DeviceLimits, TimerReportsEachPass) {
  make_method({.separate_times = true});
  const Object object = synthetic::shell(20'000, 3, 0.01, 5);
  const Camera eye = look_at({0.2, 0.3, 1.4}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.8, 160, 120);
  for (int picture = 0; picture < 3; ++picture) {
    draw(object, eye);
    const RenderTimes& times = renderer_->last_times();
    ASSERT_TRUE(times.device.has_value());
    for (const double ms :
         {times.device->project_ms, times.device->sort_ms, times.device->draw_ms, times.device->resolve_ms})
      EXPECT_GT(ms, 0.0);
    EXPECT_LE(times.device->project_ms, times.project_ms);
    EXPECT_LE(times.device->sort_ms, times.sort_ms);
    EXPECT_LE(times.device->draw_ms + times.device->resolve_ms, times.draw_ms);
  }
}

}  // namespace
}  // namespace livegs
