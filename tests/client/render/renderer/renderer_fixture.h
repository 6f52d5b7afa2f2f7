// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <tuple>

#include "common/compute/shared_vulkan.h"
#include "common/splat/synthetic_kernels.h"
#include "render/splat_renderer.h"

namespace livegs {

// Forwards to a renderer that the tests of a program share. When it is destroyed, the other one releases all
// objects.
class BorrowedRenderer final : public SplatRenderer {
 public:
  explicit BorrowedRenderer(SplatRenderer& shared) : shared_(shared) {}
  ~BorrowedRenderer() override {
    Camera eye;
    eye.width = eye.height = 16;
    std::vector<Image> images;
    (void)shared_.draw({}, {&eye, 1}, {}, images);
  }
  const std::string& name() const override { return shared_.name(); }
  Result<void> draw(std::span<const RenderedObject> objects, std::span<const Camera> eyes,
                    const RenderOptions& options, std::vector<Image>& images) override {
    return shared_.draw(objects, eyes, options, images);
  }
  Result<void> draw_into(std::span<const RenderedObject> objects, std::span<const Camera> eyes,
                         const RenderOptions& options, const DeviceImage& image) override {
    return shared_.draw_into(objects, eyes, options, image);
  }
  bool skins(DriverKind kind) const override { return shared_.skins(kind); }
  const RenderTimes& last_times() const override { return shared_.last_times(); }
  std::string notice() const override { return shared_.notice(); }

 private:
  SplatRenderer& shared_;
};

// The renderers of a test program on its shared device, one for each set of options; destroyed before the
// device.
class SharedRenderers final : public ::testing::Environment {
 public:
  Result<std::unique_ptr<SplatRenderer>> borrow(const VulkanRendererOptions& options) {
    auto& renderer = renderers_[{options.method, options.precision, options.separate_times,
                                 options.read_blended, options.max_part_rows}];
    if (!renderer) {
      auto made = create_vulkan_renderer(*shared_vulkan.device(), options);
      if (!made) return made.error();
      renderer = *std::move(made);
    }
    return Result<std::unique_ptr<SplatRenderer>>(std::make_unique<BorrowedRenderer>(*renderer));
  }
  void TearDown() override { renderers_.clear(); }

 private:
  std::map<std::tuple<DrawMethod, BlendPrecision, bool, bool, uint32_t>, std::unique_ptr<SplatRenderer>>
      renderers_;
};

inline SharedRenderers& shared_renderers = register_after_vulkan<SharedRenderers>();

// Pictures of the device found, lavapipe in CI, compared with the oracle's. Device and renderers are shared
// by the program's tests, under the validation layer; any message of it fails the test. Skips only where
// there is no device.
class VulkanPictures : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const auto& why = shared_vulkan.no_device()) GTEST_SKIP() << why->message;
    const auto& device = shared_vulkan.device();
    ASSERT_TRUE(device) << device.error().message;
    device_ = *device;
    make_renderer(
        {.method = DrawMethod::Quads, .precision = BlendPrecision::Half});  // as on most hardware devices
  }

  void TearDown() override {
    renderer_.reset();
    device_.reset();
    shared_vulkan.messages().expect_none();
  }

  void make_renderer(const VulkanRendererOptions& options) {
    auto renderer = shared_renderers.borrow(options);
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
    for (Image& image : images) {  // the range of a screen
      for (float& value : image.pixels) value = std::min(value, 1.0f);
    }
    return images;
  }
  static Image oracle(const synthetic::Object& object, const Camera& eye, const RenderOptions& options = {}) {
    const RenderedObject one = rendered(object.drawn());
    return oracle({&one, 1}, {&eye, 1}, options)[0];
  }

  std::shared_ptr<VulkanDevice> device_;
  std::unique_ptr<SplatRenderer> renderer_;
  uint64_t version_ = 1;
};

// The same by each method of drawing.
class PicturesByMethod : public VulkanPictures, public ::testing::WithParamInterface<DrawMethod> {
 protected:
  void SetUp() override {
    VulkanPictures::SetUp();
    if (device_) make_method({.precision = BlendPrecision::Half});
  }
  void make_method(VulkanRendererOptions options) {
    options.method = GetParam();
    make_renderer(options);
  }
};
inline const auto kBothMethods = ::testing::Values(DrawMethod::Quads, DrawMethod::Tiles);
inline std::string method_name(const ::testing::TestParamInfo<DrawMethod>& of) { return name_of(of.param); }

// Eight bits a channel leave 20 log10(255 sqrt 12) = 58.9 dB. What blending in halves costs on top grows with
// the number of splats a pixel sums: each sum is rounded to 2^-12 of itself, always downwards on lavapipe.
inline constexpr double kBar_db = 50.0;

}  // namespace livegs
