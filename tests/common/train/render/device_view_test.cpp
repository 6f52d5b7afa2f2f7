// SPDX-License-Identifier: Apache-2.0
// Training pictures and gradients of each backend, compared with those of the CPU code.
#include <cmath>

#include "common/compute/shared_vulkan.h"
#include "common/train/render/trained_scene.h"
#include "compute/cpu_backend.h"

namespace livegs {
namespace {

constexpr float kBySpread = 0.7f;

class DeviceView : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (GetParam() == std::string("cpu")) return;
    if (const auto& why = shared_vulkan.no_device()) GTEST_SKIP() << why->message;
  }
  void TearDown() override { shared_vulkan.messages().expect_none(); }

  static std::unique_ptr<Backend> backend() {
    if (GetParam() == std::string("cpu")) return std::make_unique<CpuBackend>();
    auto made = create_vulkan_backend(*shared_vulkan.device());
    EXPECT_TRUE(made) << made.error().message;
    return *std::move(made);
  }

  struct Result {
    PicturePlanes picture;
    std::vector<float> depths;
    double spread = 0;
    KernelParameters gradient;
  };
  static Result of(TrainedView& view, const KernelParameters& kernels, const Camera& camera,
                   TrainedViewOptions options, float by_spread) {
    options.spread = by_spread != 0;
    options.depth = true;
    Result result;
    view.draw(kernels, camera, options);
    result.picture = view.picture();
    result.depths = view.depths();
    for (const float one : view.spreads()) result.spread += one;
    std::vector<float> spread_weights;  // they differ between pixels
    for (size_t i = 0; options.spread && i < view.spreads().size(); ++i)
      spread_weights.push_back(by_spread * static_cast<float>(1 + i % 3));
    view.backward(kernels, random_weights(camera.width, camera.height), result.gradient, spread_weights);
    return result;
  }
  static Result on_cpu(const KernelParameters& kernels, const Camera& camera,
                       const TrainedViewOptions& options, float by_spread) {
    TrainedView view;
    return of(view, kernels, camera, options, by_spread);
  }
  static Result on_device(const KernelParameters& kernels, const Camera& camera,
                          const TrainedViewOptions& options, float by_spread) {
    TrainedView view;
    view.use_device(backend());
    return of(view, kernels, camera, options, by_spread);
  }

  static double relative_error(const std::vector<float>& made, const std::vector<float>& expected) {
    EXPECT_EQ(made.size(), expected.size());
    double error = 0, norm = 0;
    for (size_t i = 0; i < std::min(made.size(), expected.size()); ++i) {
      error += std::pow(double{made[i]} - expected[i], 2);
      norm += std::pow(double{expected[i]}, 2);
    }
    EXPECT_GT(norm, 0);
    return std::sqrt(error / norm);
  }
  static void expect_same(const Result& made, const Result& expected, double tolerance) {
    EXPECT_LE(relative_error(made.picture.red, expected.picture.red), 1e-4);
    EXPECT_LE(relative_error(made.picture.green, expected.picture.green), 1e-4);
    EXPECT_LE(relative_error(made.picture.blue, expected.picture.blue), 1e-4);
    EXPECT_LE(relative_error(made.picture.alpha, expected.picture.alpha), 1e-4);
    EXPECT_NEAR(made.spread, expected.spread, 1e-4 * expected.spread);
    size_t other_depths = 0;  // at a pixel near a half another kernel may be the halfway one
    for (size_t i = 0; i < expected.depths.size(); ++i)
      other_depths += made.depths[i] == expected.depths[i] ? 0 : 1;
    EXPECT_LE(other_depths, 1 + expected.depths.size() / 1000);
    for (size_t f = 0; f < kFamilies; ++f) {
      EXPECT_LE(relative_error(made.gradient.families[f], expected.gradient.families[f]), tolerance)
          << "family " << f;
    }
  }
};
INSTANTIATE_TEST_SUITE_P(Backend, DeviceView, ::testing::Values("cpu", "vulkan"),
                         [](const auto& of) { return std::string(of.param); });

// Without the cut-offs, all differences are rounding.
TEST_P(DeviceView, PicturesAndGradientsMatchTheCpu) {
  const KernelParameters kernels = test_kernels(300, 0.95);
  const Camera camera = test_camera(70, 50);
  for (const float by_spread : {0.0f, kBySpread}) {
    SCOPED_TRACE(by_spread);
    expect_same(on_device(kernels, camera, smooth_options(), by_spread),
                on_cpu(kernels, camera, smooth_options(), by_spread), 1e-4);
  }
}

// With them, rounding decides single pixels of single kernels: a contribution of 1/255 or of a transmittance
// of 1e-4.
TEST_P(DeviceView, CutOffsAreThoseOfTheCpu) {
  const KernelParameters kernels = test_kernels(3000, 0.95);
  const Camera camera = test_camera(100, 76);
  TrainedViewOptions options;
  options.background = {0.2f, 0.5f, 0.8f};
  expect_same(on_device(kernels, camera, options, kBySpread), on_cpu(kernels, camera, options, kBySpread),
              1e-3);
}

TEST_P(DeviceView, RepeatedStepsAreBitIdentical) {
  const KernelParameters first = test_kernels(800, 0.9), second = test_kernels(1500, 0.9);
  const Camera camera = test_camera(64, 48), larger = test_camera(90, 60);
  TrainedView view;
  view.use_device(backend());
  const Result once = of(view, first, camera, {}, kBySpread);
  of(view, second, larger, {}, 0);  // other sizes between them
  const Result again = of(view, first, camera, {}, kBySpread);
  EXPECT_EQ(again.picture.red, once.picture.red);
  EXPECT_EQ(again.gradient.families, once.gradient.families);
}

TEST_P(DeviceView, NoKernelGivesTheBackground) {
  KernelParameters behind = test_kernels(5, 0.9);
  for (size_t k = 0; k < behind.size(); ++k)
    behind.row(Family::Position, k)[2] += 100.0f;  // behind the camera
  TrainedViewOptions options;
  options.background = {0.2f, 0.5f, 0.8f};
  TrainedView view;
  view.use_device(backend());
  view.draw(behind, test_camera(20, 18), options);
  for (size_t i = 0; i < view.picture().pixels(); ++i) {
    EXPECT_EQ(view.picture().green[i], 0.5f);
    EXPECT_EQ(view.picture().alpha[i], 0.0f);
  }
  KernelParameters gradient;
  view.backward(behind, random_weights(20, 18), gradient);
  for (const auto& family : gradient.families) {
    for (const float one : family) EXPECT_EQ(one, 0.0f);
  }
}

// A backend that fails from some dispatch on.
class FailingBackend final : public Backend {
 public:
  FailingBackend(int dispatches, bool& failed) : left_(dispatches), failed_(failed) {}
  ::livegs::Result<BufferId> create_buffer(size_t bytes) override { return cpu_.create_buffer(bytes); }
  ::livegs::Result<void> destroy_buffer(BufferId buffer) override { return cpu_.destroy_buffer(buffer); }
  ::livegs::Result<void> upload(BufferId buffer, std::span<const std::byte> bytes) override {
    return cpu_.upload(buffer, bytes);
  }
  ::livegs::Result<void> dispatch(const Pass& pass, std::span<const BufferId> buffers,
                                  std::span<const std::byte> constants, uint32_t count) override {
    if (left_-- <= 0) {
      failed_ = true;
      return Error{ErrorCode::Unavailable, "vulkan: the device is lost"};
    }
    return cpu_.dispatch(pass, buffers, constants, count);
  }
  ::livegs::Result<void> submit() override { return cpu_.submit(); }
  ::livegs::Result<void> read(BufferId buffer, std::span<std::byte> bytes) override {
    return cpu_.read(buffer, bytes);
  }

 private:
  CpuBackend cpu_;
  int left_;
  bool& failed_;
};

TEST(DeviceLoss, TheCpuGoesOnWithTheSameBits) {
  const KernelParameters kernels = test_kernels(200, 0.95);
  const Camera camera = test_camera(50, 40);
  const PicturePlanes weights = random_weights(50, 40);
  KernelParameters expected, made;
  TrainedView cpu;
  cpu.draw(kernels, camera, {});
  cpu.backward(kernels, weights, expected);
  int failures = 0;
  for (int dispatches = 0; dispatches < 20; ++dispatches) {  // in binning, in blending, on the way back
    bool failed = false;
    TrainedView view;
    view.use_device(std::make_unique<FailingBackend>(dispatches, failed));
    view.draw(kernels, camera, {});
    view.backward(kernels, weights, made);
    failures += failed ? 1 : 0;
    if (!failed) {
      view.draw(kernels, camera, {});
      view.backward(kernels, weights, made);
      EXPECT_TRUE(failed);
    }
    EXPECT_EQ(made.families, expected.families) << dispatches;
  }
  EXPECT_GT(failures, 10);
}

}  // namespace
}  // namespace livegs
