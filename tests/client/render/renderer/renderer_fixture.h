// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/compute/backends.h"
#include "common/splat/synthetic_kernels.h"
#include "render/splat_renderer.h"

namespace livegs {

// Pictures of the device found, lavapipe in CI, beside the oracle's. The validation layer looks on, and any
// message fails the test. Skips only where there is no device.
class VulkanPictures : public testing::Test {
 protected:
  void SetUp() override {
    auto plain = VulkanDevice::create();
    if (!plain) GTEST_SKIP() << plain.error().message;
    VulkanDeviceOptions options;
    options.validation = true;
    options.on_validation_message = [this](const std::string& message) { messages_.add(message); };
    auto device = VulkanDevice::create(options);
    ASSERT_TRUE(device) << device.error().message;
    device_ = *std::move(device);
    make_renderer({.precision = BlendPrecision::Half});  // what a device that is not software draws with
  }

  void TearDown() override {
    renderer_.reset();
    device_.reset();
    for (const std::string& message : messages_.take()) ADD_FAILURE() << message;
  }

  void make_renderer(const VulkanRendererOptions& options) {
    auto renderer = create_vulkan_renderer(device_, options);
    ASSERT_TRUE(renderer) << renderer.error().message;
    renderer_ = *std::move(renderer);
  }

  static RenderedObject rendered(const DrawnObject& drawn, uint64_t version = 1) {
    return {drawn, version, version};
  }

  std::vector<Image> draw(std::span<const RenderedObject> objects, std::span<const Camera> eyes,
                          const RenderOptions& options = {}) {
    std::vector<Image> images;
    const auto done = renderer_->draw(objects, eyes, options, images);
    EXPECT_TRUE(done) << done.error().message;
    return images;
  }
  Image draw(const synthetic::Object& object, const Camera& eye, const RenderOptions& options = {}) {
    const RenderedObject one = rendered(object.drawn(), ++version_);
    auto images = draw({&one, 1}, {&eye, 1}, options);
    return images.empty() ? Image{} : images[0];
  }

  static std::vector<Image> oracle(std::span<const RenderedObject> objects, std::span<const Camera> eyes,
                                   const RenderOptions& options = {}) {
    std::vector<Image> images;
    EXPECT_TRUE(create_cpu_renderer()->draw(objects, eyes, options, images));
    for (Image& image : images) {  // what a screen can show
      for (float& value : image.pixels) value = std::min(value, 1.0f);
    }
    return images;
  }
  static Image oracle(const synthetic::Object& object, const Camera& eye, const RenderOptions& options = {}) {
    const RenderedObject one = rendered(object.drawn());
    return oracle({&one, 1}, {&eye, 1}, options)[0];
  }

  ValidationMessages messages_;  // outlives the device, which speaks until it is gone
  std::shared_ptr<VulkanDevice> device_;
  std::unique_ptr<SplatRenderer> renderer_;
  uint64_t version_ = 1;
};

// Eight bits a channel leave 20 log10(255 sqrt 12) = 58.9 dB. What blending in halves costs on top grows with
// the number of splats a pixel sums: each sum is rounded to 2^-12 of itself, always downwards on lavapipe.
inline constexpr double kBar_db = 50.0;

}  // namespace livegs
