// SPDX-License-Identifier: Apache-2.0
// A head leans into an object: every kernel near the eye covers the picture, the worst case for a device that
// draws quads. Reducing the size of late pictures bounds the cost.
#include <time.h>

#include <algorithm>

#include "client/render/renderer/renderer_fixture.h"
#include "viewer/camera/render_scale.h"

namespace livegs {
namespace {

constexpr int kWidth = 480, kHeight = 360, kSteps = 8, kStays = 8;
constexpr double kOutside_m = 3, kInside_m = 0.2;  // from the centre of a shell of radius 0.5 m
// Limits of the cost inside the shell relative to the cost outside, with and without smaller pictures.
constexpr double kMaxShare = 1.6, kMinUnscaled = 2;

class LeanInto : public VulkanPictures {
 protected:
  // On a software device, processor time of all threads, which other programs hardly affect; else device
  // time.
  double draw_ms(const RenderedObject& object, double distance, const RenderScale* scale) {
    const int width = scale ? scale->of(kWidth) : kWidth, height = scale ? scale->of(kHeight) : kHeight;
    const Eigen::Vector3d toward = Eigen::Vector3d(0.3, 0.25, 1.0).normalized();
    const Camera eye =
        look_at(distance * toward, (distance - 1) * toward, Eigen::Vector3d::UnitY(), 0.8, width, height);
    RenderOptions options;  // as in SceneView
    options.min_contribution_px = scale ? scale->min_contribution_px() : 0.0f;
    options.max_radius_px = static_cast<float>((options.min_contribution_px > 0 ? 1 : 2) * width);
    const double begun_ms = processor_ms();
    draw({&object, 1}, {&eye, 1}, options);
    const double passed_ms = processor_ms() - begun_ms;
    const auto& device = renderer_->last_times().device;
    return device_->is_software() || !device ? passed_ms : device->total_ms();
  }

  // Moves from outside to inside and stays there; returns the median of the last times.
  double inside_ms(const RenderedObject& object, RenderScale* scale) {
    std::vector<double> stayed_ms;
    for (int step = 0; step < kSteps + kStays; ++step) {
      const double along = std::min(1.0, static_cast<double>(step) / (kSteps - 1));
      const double ms = draw_ms(object, kOutside_m + (kInside_m - kOutside_m) * along, scale);
      if (scale) scale->drew(ms);
      if (step >= kSteps + kStays / 2) stayed_ms.push_back(ms);
    }
    return middle(stayed_ms);
  }

  static double middle(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
  }

 private:
  static double processor_ms() {
    timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
  }
};

TEST_F(LeanInto, SmallerPicturesBoundCostInside) {
  const synthetic::Object shell = synthetic::shell(2'000, 1, 0.06, 1);
  const RenderedObject object = rendered(shell.drawn());
  std::vector<double> outside;
  for (int i = 0; i < 5; ++i) outside.push_back(draw_ms(object, kOutside_m, nullptr));
  const double outside_ms = middle(outside);
  RenderScale scale(1.2 * outside_ms);
  const double unscaled_ms = inside_ms(object, nullptr), scaled_ms = inside_ms(object, &scale);
  std::printf("%s: outside %.1f ms, inside %.1f ms, at %.0f %% of the size %.1f ms\n",
              device_->name().c_str(), outside_ms, unscaled_ms, 100 * scale.value(), scaled_ms);
  EXPECT_LT(scaled_ms, kMaxShare * outside_ms);
  EXPECT_GT(unscaled_ms, kMinUnscaled * outside_ms);  // otherwise the test shows nothing
  EXPECT_LT(scale.value(), 1.0);
}

}  // namespace
}  // namespace livegs
