// SPDX-License-Identifier: Apache-2.0
// A head that leans into a thing: kernels before the eye cover the picture, each of them, which is what keeps
// a device that draws quads busy. Pictures that are late are drawn smaller, and that holds their cost.
#include <time.h>

#include <algorithm>

#include "client/render/renderer/renderer_fixture.h"
#include "viewer/camera/render_scale.h"

namespace livegs {
namespace {

constexpr int kWidth = 480, kHeight = 360, kSteps = 8, kStays = 8;
constexpr double kOutside_m = 3, kInside_m = 0.2;  // from the middle of a shell of radius 0.5 m
// Inside of the shell, as a share of the cost outside: 0.9 and 3.0 found on lavapipe, with smaller pictures
// and without.
constexpr double kMaxShare = 1.6, kMinUnscaled = 2;

class LeanInto : public VulkanPictures {
 protected:
  // Of a device in software, processor time of all threads, which other programs hardly change; else by the
  // device's clock.
  double draw_ms(const RenderedObject& object, double distance, const RenderScale* scale) {
    const int width = scale ? scale->of(kWidth) : kWidth, height = scale ? scale->of(kHeight) : kHeight;
    const Eigen::Vector3d toward = Eigen::Vector3d(0.3, 0.25, 1.0).normalized();
    const Camera eye =
        look_at(distance * toward, (distance - 1) * toward, Eigen::Vector3d::UnitY(), 0.8, width, height);
    RenderOptions options;  // as SceneView has them
    options.min_contribution_px = scale ? scale->min_contribution_px() : 0.0f;
    options.max_radius_px = static_cast<float>((options.min_contribution_px > 0 ? 1 : 2) * width);
    const double begun_ms = processor_ms();
    draw({&object, 1}, {&eye, 1}, options);
    const double passed_ms = processor_ms() - begun_ms;
    const auto& device = renderer_->last_times().device;
    return device_->is_software() || !device ? passed_ms : device->total_ms();
  }

  // From outside to inside, and a while there: the middle one of the last ones.
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

TEST_F(LeanInto, SmallerPicturesHoldTheCostInside) {
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
  EXPECT_GT(unscaled_ms, kMinUnscaled * outside_ms);  // or there was nothing to hold
  EXPECT_LT(scale.value(), 1.0);
}

}  // namespace
}  // namespace livegs
