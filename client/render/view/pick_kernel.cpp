// SPDX-License-Identifier: Apache-2.0
#include "render/view/pick_kernel.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

namespace livegs {
namespace {

constexpr float kReach = 3.0f;  // standard deviations
constexpr float kMinOpacity = 0.02f;
constexpr float kMinTrace = 1e-6f;  // times the trace, added to make a flat kernel invertible

struct Crossing {
  float distance_m, opacity;
  uint32_t object, kernel;
};

}  // namespace

std::optional<PickedKernel> pick_kernel(std::span<const DrawnObject> objects, const Eigen::Vector3d& origin_m,
                                        const Eigen::Vector3d& direction, double near_m) {
  const Eigen::Vector3f origin = origin_m.cast<float>(), along = direction.cast<float>();
  std::vector<Crossing> crossings;
  for (size_t i = 0; i < objects.size(); ++i) {
    const PosedKernels& kernels = *objects[i].kernels;
    for (size_t k = 0; k < kernels.positions_m.size(); ++k) {
      const Eigen::Vector3f to = kernels.positions_m[k] - origin;
      const float middle = to.dot(along);
      if (middle < near_m) continue;
      const Symmetric3f& s = kernels.covariances_m2[k];
      const float trace = s[0] + s[3] + s[5];
      if (to.squaredNorm() - middle * middle > kReach * kReach * trace) continue;
      Eigen::Matrix3f covariance;
      covariance << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
      covariance.diagonal().array() += kMinTrace * trace;
      const Eigen::Matrix3f inverse = covariance.inverse();
      // (o + t d - p)ᵀ Σ⁻¹ (o + t d - p) is minimal at t = dᵀ Σ⁻¹ (p - o) / dᵀ Σ⁻¹ d.
      const float bend = along.dot(inverse * along);
      const float distance = along.dot(inverse * to) / bend;
      const float exponent = (to - distance * along).dot(inverse * (to - distance * along));
      const float opacity =
          std::exp(-0.5f * exponent) / (1.0f + std::exp(-objects[i].asset->opacity_logits[k]));
      if (!(opacity > kMinOpacity) || distance < near_m) continue;
      crossings.push_back({distance, opacity, static_cast<uint32_t>(i), static_cast<uint32_t>(k)});
    }
  }
  std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
    return std::tie(a.distance_m, a.object, a.kernel) < std::tie(b.distance_m, b.object, b.kernel);
  });
  float passes = 1;
  for (const Crossing& crossing : crossings) {
    passes *= 1 - std::min(crossing.opacity, 0.99f);
    if (passes <= 0.5f) return PickedKernel{crossing.object, crossing.kernel, crossing.distance_m};
  }
  return std::nullopt;
}

}  // namespace livegs
