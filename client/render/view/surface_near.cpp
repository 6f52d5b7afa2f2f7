// SPDX-License-Identifier: Apache-2.0
#include "render/surface_near.h"

#include <cmath>
#include <limits>

namespace livegs {

std::vector<SurfaceKernel> surface_within(std::span<const DrawnObject> objects,
                                          const Eigen::AlignedBox3f& box, size_t most) {
  std::vector<SurfaceKernel> found;
  for (const DrawnObject& object : objects) {
    const std::vector<Eigen::Vector3f>& middles = object.kernels->positions_m;
    for (size_t i = 0; i < middles.size(); ++i) {
      if (box.contains(middles[i]) && object.asset->opacity_logits[i] > 0)
        found.push_back({middles[i], object.kernels->covariances_m2[i], object.object_id});
    }
  }
  if (found.size() <= most) return found;
  std::vector<SurfaceKernel> kept;
  for (size_t i = 0; i < most; ++i) kept.push_back(found[i * found.size() / most]);
  return kept;
}

float distance_to_surface(std::span<const SurfaceKernel> surface, const Eigen::Vector3f& place_m) {
  float least = std::numeric_limits<float>::infinity();
  for (const SurfaceKernel& point : surface) {
    const Eigen::Vector3f d = place_m - point.middle_m;
    const float distance = d.norm();
    const Symmetric3f& s = point.covariance_m2;
    const float along = s[0] * d.x() * d.x() + s[3] * d.y() * d.y() + s[5] * d.z() * d.z() +
                        2 * (s[1] * d.x() * d.y() + s[2] * d.x() * d.z() + s[4] * d.y() * d.z());
    // Standard deviation of the kernel's marginal in the direction of the point.
    least = std::min(least, distance > 0 ? distance - std::sqrt(std::max(0.0f, along)) / distance : 0.0f);
  }
  return least;
}

}  // namespace livegs
