// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/faster_method.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "core/log.h"

namespace livegs {
namespace {

constexpr uint32_t kKernels = 100'000;
constexpr int kSide_px = 1024;
constexpr int kPictures = 4;  // of each method; the first one allocates and is not timed

// A ball of the size of the picture. Kernels have about three pixels standard deviation and hide each other,
// as in captured objects.
void fill_ball(GaussianAsset& asset, PosedKernels& posed) {
  constexpr float kRadius_m = 0.5f, kDeviation_m = 0.003f;
  std::mt19937 random(1);
  const auto uniform = [&] { return static_cast<float>(random()) / 4294967296.0f; };
  posed.resize(kKernels);
  asset.positions.resize(kKernels);
  asset.log_scales.assign(kKernels, Eigen::Vector3f::Constant(std::log(kDeviation_m)));
  asset.rotations.assign(kKernels, Eigen::Quaternionf::Identity());
  asset.sh_dc.assign(kKernels, Eigen::Vector3f::Zero());
  asset.opacity_logits.assign(kKernels, 1.0f);
  for (uint32_t k = 0; k < kKernels; ++k) {
    Eigen::Vector3f direction;
    do {
      for (int i = 0; i < 3; ++i) direction[i] = 2.0f * uniform() - 1.0f;
    } while (direction.squaredNorm() > 1.0f || direction.squaredNorm() < 1e-4f);
    posed.positions_m[k] = asset.positions[k] =
        kRadius_m * (0.9f + 0.1f * uniform()) * direction.normalized();
    constexpr float kVariance_m2 = kDeviation_m * kDeviation_m;
    posed.covariances_m2[k] = {kVariance_m2, 0, 0, kVariance_m2, 0, kVariance_m2};
    posed.world_from_asset[k].setIdentity();
  }
}

// Device time of a draw, milliseconds; infinity without a clock.
Result<double> draw_ms(const std::shared_ptr<VulkanDevice>& device, DrawMethod method,
                       const RenderedObject& object, const Camera& eye) {
  auto renderer = create_vulkan_renderer(device, {.method = method});
  if (!renderer) return renderer.error();
  double least = std::numeric_limits<double>::infinity();
  std::vector<Image> images;
  for (int picture = 0; picture < kPictures; ++picture) {
    if (auto done = (*renderer)->draw({&object, 1}, {&eye, 1}, {}, images); !done) return done.error();
    const auto& times = (*renderer)->last_times().device;
    if (picture > 0 && times) least = std::min(least, times->draw_ms + times->resolve_ms);
  }
  return least;
}

}  // namespace

Result<DrawMethod> faster_method(const std::shared_ptr<VulkanDevice>& device) {
  if (!device->can_draw() || device->is_software()) return DrawMethod::Tiles;
  GaussianAsset asset;
  PosedKernels posed;
  fill_ball(asset, posed);
  const RenderedObject object{{&asset, &posed, 0}, 1, 1};
  const Camera eye = look_at({0, 0, 1.5}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.75, kSide_px, kSide_px);
  const auto quads_ms = draw_ms(device, DrawMethod::Quads, object, eye);
  const auto tiles_ms = draw_ms(device, DrawMethod::Tiles, object, eye);
  if (!quads_ms && !tiles_ms) {
    // Without memory for the test picture smaller ones may fit.
    if (tiles_ms.error().code == ErrorCode::TooLarge) return DrawMethod::Quads;
    return tiles_ms.error();
  }
  if (!quads_ms || !tiles_ms) {
    const DrawMethod failed = quads_ms ? DrawMethod::Tiles : DrawMethod::Quads;
    const DrawMethod other = quads_ms ? DrawMethod::Quads : DrawMethod::Tiles;
    log_warn("%s: no test picture by %s (%s); drawing by %s", device->name().c_str(), name_of(failed),
             (quads_ms ? tiles_ms : quads_ms).error().message.c_str(), name_of(other));
    return other;
  }
  if (!std::isfinite(*tiles_ms)) return DrawMethod::Quads;  // no clock
  const DrawMethod faster = *tiles_ms < *quads_ms ? DrawMethod::Tiles : DrawMethod::Quads;
  log_info("%s: a test picture takes %.2f ms by quads, %.2f ms by tiles; drawing by %s",
           device->name().c_str(), *quads_ms, *tiles_ms, name_of(faster));
  return faster;
}

}  // namespace livegs
