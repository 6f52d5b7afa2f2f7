// SPDX-License-Identifier: Apache-2.0
#include "splat/tiles/image_rasteriser.h"

#include "common/compute/backends.h"
#include "common/splat/synthetic_kernels.h"

namespace livegs {
namespace {

using synthetic::Object;

constexpr double kImageBar_db = 70.0;

class ImageRasteriserTest : public OnEveryBackend {
 protected:
  static std::unique_ptr<Backend> own_backend() {
    if (GetParam() == std::string("cpu")) return std::make_unique<CpuBackend>();
    auto made = create_vulkan_backend(*shared_vulkan.device());
    EXPECT_TRUE(made) << made.error().message;
    return *std::move(made);
  }
};
INSTANTIATE_TEST_SUITE_P(Backend, ImageRasteriserTest, ::testing::Values("cpu", "vulkan"), backend_name);

Camera from_the_front() {
  return look_at({0.1, 0.2, 1.6}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.8, 130, 90);
}

// Objects that move, change and leave between the images, and an environment with its order.
TEST_P(ImageRasteriserTest, ImagesAreThoseOfTheCpu) {
  const Object shell = synthetic::shell(1500, 2, 0.03, 1);
  Object other = synthetic::shell(800, 1, 0.04, 2);
  other.id = 7;
  Object moved = synthetic::moved(other, {{0.2, 0.1, 0}, Eigen::Quaterniond::Identity()});
  moved.id = 7;
  Object changed = synthetic::shell(800, 1, 0.04, 3);
  changed.id = 7;
  RasteriseOptions options;
  options.background = {0.3f, 0.2f, 0.1f};
  options.environments = {shell.id};
  ImageRasteriser device(own_backend()), cpu;
  ASSERT_TRUE(device.on_device());
  EXPECT_FALSE(cpu.on_device());
  const std::vector<std::vector<const Object*>> images{
      {&shell, &other}, {&shell, &moved}, {&shell, &changed}, {&shell}, {}};
  for (const auto& objects : images) {
    std::vector<DrawnObject> drawn;
    for (const Object* object : objects) drawn.push_back(object->drawn());
    Image made, expected;
    device.draw(drawn, from_the_front(), options, made);
    cpu.draw(drawn, from_the_front(), options, expected);
    EXPECT_GE(psnr_db(made, expected), kImageBar_db) << objects.size();
    EXPECT_NEAR(static_cast<double>(device.visible_kernels()), static_cast<double>(cpu.visible_kernels()),
                0.01 * static_cast<double>(cpu.visible_kernels()));
  }
  EXPECT_TRUE(device.on_device());
}

TEST(ImageRasteriserLoss, TheCpuGoesOn) {
  const Object shell = synthetic::shell(500, 1, 0.04, 4);
  const DrawnObject drawn = shell.drawn();
  class Lost final : public Backend {
    Result<BufferId> create_buffer(size_t) override { return lost(); }
    Result<void> destroy_buffer(BufferId) override { return lost(); }
    Result<void> upload(BufferId, std::span<const std::byte>) override { return lost(); }
    Result<void> dispatch(const Pass&, std::span<const BufferId>, std::span<const std::byte>,
                          uint32_t) override {
      return lost();
    }
    Result<void> submit() override { return lost(); }
    Result<void> read(BufferId, std::span<std::byte>) override { return lost(); }
    static Error lost() { return {ErrorCode::Unavailable, "vulkan: the device is lost"}; }
  };
  ImageRasteriser device(std::make_unique<Lost>()), cpu;
  Image made, expected;
  device.draw({&drawn, 1}, from_the_front(), {}, made);
  cpu.draw({&drawn, 1}, from_the_front(), {}, expected);
  EXPECT_FALSE(device.on_device());
  EXPECT_EQ(made.pixels, expected.pixels);
}

}  // namespace
}  // namespace livegs
