// SPDX-License-Identifier: Apache-2.0
// Mao et al., LIVE-GS: LLM Powers Interactive VR Experience with Physics-Aware Gaussian Splatting, eq. 3
// to 6. With rest offsets t_i = x0 - p_i and weights that sum to 1, their
//   x = x0 + sum w_i dt_i + sum w_i (dq_i t_i dq_i^-1 - t_i)   is   x = sum w_i (p_i' + dq_i t_i dq_i^-1).
#include <array>
#include <cmath>

#include "core/assert.h"
#include "core/parallel_for.h"
#include "skin/kernels/driver_skinning.h"
#include "skin/kernels/nearest_cubes.h"

namespace livegs {
namespace {

// Below this distance, m, a kernel coincides with its particle, which then has the whole weight.
constexpr float kCoincident_m = 1e-7f;

// sin(t a) / sin(a) for cos a = 1 + below, -0.1 <= below <= 0, 0 <= t <= 1 (Eberly 2011, A fast and accurate
// algorithm for computing slerp). Each term is at most 5 % of the one before, so six terms reach float
// precision.
float sine_ratio(float t, float below) {
  const float tt = t * t;
  float sum = 1.0f;
  for (int i = 6; i >= 1; --i) {
    const float n = static_cast<float>(i);
    sum = 1.0f + (tt / (n * (2.0f * n + 1.0f)) - n / (2.0f * n + 1.0f)) * below * sum;
  }
  return t * sum;
}

// Shortest-path spherical interpolation. Rotations of neighbouring particles are similar; below 26 degrees no
// trigonometric function is needed.
Eigen::Quaternionf slerp(const Eigen::Quaternionf& from, const Eigen::Quaternionf& to, float t) {
  float cosine = from.dot(to);
  const float sign = cosine < 0.0f ? -1.0f : 1.0f;
  cosine = std::min(cosine * sign, 1.0f);
  if (cosine >= 0.9f) {
    const float below = cosine - 1.0f;
    Eigen::Quaternionf result;
    result.coeffs() =
        from.coeffs() * sine_ratio(1.0f - t, below) + to.coeffs() * (sign * sine_ratio(t, below));
    return result;
  }
  return from.slerp(t, to);
}

}  // namespace

Result<void> bind_particles(const RestKernels& kernels, const RestBody& rest, KernelBindings& bindings) {
  if (rest.particles_m.empty()) return invalid_argument("rest body: no particles");
  for (size_t p = 0; p < rest.particles_m.size(); ++p) {
    if (!rest.particles_m[p].allFinite()) {
      return invalid_argument("rest body: particle " + std::to_string(p) + " is not finite");
    }
  }
  const NearestCubes particles(rest.particles_m, 0.0f);

  bindings.rest_positions_m.resize(kernels.positions_m.size());
  parallel_for(kernels.positions_m.size(), kSkinBlock, [&](size_t begin, size_t end) {
    for (size_t k = begin; k < end; ++k) {
      bindings.rest_positions_m[k] = kernels.positions_m[k].cast<float>();
      bindings.rest_covariances_m2[k] = symmetric_of(kernels.covariances_m2[k]);
      std::array<NearestCubes::Neighbour, kParticlesPerKernel> nearest;
      const size_t found = particles.find(bindings.rest_positions_m[k], nearest);
      KernelBinding& binding = bindings.kernels[k];
      float sum = 0.0f;
      for (size_t i = 0; i < found; ++i) {
        const float distance_m = std::sqrt(nearest[i].distance_squared);
        binding.drivers[i] = nearest[i].index;
        if (i == 0 && distance_m < kCoincident_m) {
          binding.weights[0] = sum = 1.0f;
          break;
        }
        // Relative to the nearest, so that no distance overflows.
        binding.weights[i] = std::sqrt(nearest[0].distance_squared) / distance_m;
        sum += binding.weights[i];
      }
      for (float& weight : binding.weights) weight /= sum;
    }
  });
  return {};
}

void skin_particles(const RestBody& rest, const KernelBindings& bindings, const ObjectDrivers& drivers,
                    PosedKernels& kernels, std::vector<Eigen::Matrix3f>* deformation_gradients) {
  LIVEGS_ASSERT(drivers.positions_m.size() == rest.particles_m.size());
  LIVEGS_ASSERT(drivers.rotations.size() == rest.particles_m.size());
  const Eigen::Quaternionf object_from_asset = rest.object_from_asset.rotation.cast<float>();
  parallel_for(bindings.kernels.size(), kSkinBlock, [&](size_t begin, size_t end) {
    for (size_t k = begin; k < end; ++k) {
      const KernelBinding& binding = bindings.kernels[k];
      Eigen::Vector3f position = Eigen::Vector3f::Zero();
      Eigen::Quaternionf turn = drivers.rotations[binding.drivers[0]];
      float weight_so_far = 0.0f;
      for (int i = 0; i < kParticlesPerKernel && binding.weights[i] > 0.0f; ++i) {
        const uint32_t p = binding.drivers[i];
        const Eigen::Quaternionf& particle_turn = drivers.rotations[p];
        const Eigen::Vector3f offset = bindings.rest_positions_m[k] - rest.particles_m[p];
        position += binding.weights[i] * (drivers.positions_m[p] + particle_turn._transformVector(offset));
        weight_so_far += binding.weights[i];
        if (i > 0) turn = slerp(turn, particle_turn, binding.weights[i] / weight_so_far);
      }
      turn.normalize();
      const Eigen::Matrix3f rotation = turn.toRotationMatrix();
      kernels.positions_m[k] = position;
      kernels.covariances_m2[k] = transformed(rotation, bindings.rest_covariances_m2[k]);
      kernels.world_from_asset[k] = turn * object_from_asset;
      if (deformation_gradients) (*deformation_gradients)[k] = rotation;
    }
  });
}

}  // namespace livegs
