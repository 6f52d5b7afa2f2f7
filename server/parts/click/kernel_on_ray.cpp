// SPDX-License-Identifier: GPL-3.0-or-later
#include "parts/click/kernel_on_ray.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/parallel_for.h"
#include "gaussian/opacity.h"

namespace livegs {
namespace {

using Eigen::Vector3f;

constexpr size_t kRayBlock = 65536;     // kernels
constexpr float kRayDeviations = 3.0f;  // of a kernel that a ray meets

}  // namespace

std::optional<uint32_t> kernel_on_ray(const GaussianAsset& asset, const Eigen::Vector3d& origin_m,
                                      const Eigen::Vector3d& direction) {
  struct Met {
    float t, alpha;
    uint32_t kernel;
  };
  const Vector3f origin = origin_m.cast<float>(), ray = direction.cast<float>();
  std::vector<std::vector<Met>> of_block((asset.size() + kRayBlock - 1) / kRayBlock);
  parallel_for(asset.size(), kRayBlock, [&](size_t begin, size_t end) {
    for (size_t k = begin; k < end; ++k) {
      const Vector3f d = asset.positions[k] - origin;
      const float along = d.dot(ray), reach_m = kRayDeviations * std::exp(asset.log_scales[k].maxCoeff());
      if (along < -reach_m || d.squaredNorm() - along * along > reach_m * reach_m) continue;
      // In the frame of the kernel, in deviations.
      const Eigen::Quaternionf turn = asset.rotations[k].conjugate();
      const Eigen::Array3f inverse = (-asset.log_scales[k].array().max(-16.0f)).exp();
      const Vector3f from = (inverse * (turn * d).array()).matrix(),
                     step = (inverse * (turn * ray).array()).matrix();
      const float t = step.dot(from) / step.squaredNorm();
      if (!(t > 0)) continue;
      const float alpha = std::min(0.99f, opacity_of_logit(asset.opacity_logits[k]) *
                                              std::exp(-0.5f * (from - t * step).squaredNorm()));
      if (alpha >= 1.0f / 255.0f) of_block[begin / kRayBlock].push_back({t, alpha, static_cast<uint32_t>(k)});
    }
  });
  std::vector<Met> met;
  for (const auto& some : of_block) met.insert(met.end(), some.begin(), some.end());
  std::sort(met.begin(), met.end(),
            [](const Met& a, const Met& b) { return a.t < b.t || (a.t == b.t && a.kernel < b.kernel); });
  float transmittance = 1;
  for (const Met& one : met) {
    transmittance *= 1 - one.alpha;
    if (transmittance < 0.5f) return one.kernel;
  }
  return {};
}

}  // namespace livegs
