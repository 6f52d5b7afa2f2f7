// SPDX-License-Identifier: Apache-2.0
#include "skin/kernels/kernel_reach.h"

#include <algorithm>
#include <cmath>

namespace livegs {
namespace {

constexpr float kReachDeviations = 3.0f;
constexpr float kRounding = 1.0001f;

float extent_m(const Symmetric3f& covariance_m2) {  // the trace is an upper bound of the largest variance
  return kReachDeviations * std::sqrt(std::max(0.0f, covariance_m2[0] + covariance_m2[3] + covariance_m2[5]));
}

// A kernel inside its cell is at a mean of node positions. F stretches its offset outside the cell, and its
// own size.
float lattice_reach_m(const RestBody& rest, const KernelBindings& bindings) {
  float reach_m = 0;
  for (size_t k = 0; k < bindings.kernels.size(); ++k) {
    const Eigen::Array3f local = Eigen::Array3f::Map(bindings.kernels[k].weights.data());
    const float beyond = (local - local.max(0.0f).min(1.0f)).matrix().norm();
    reach_m = std::max(
        reach_m, beyond * static_cast<float>(rest.cell_width_m) + extent_m(bindings.rest_covariances_m2[k]));
  }
  return kMaxKernelStretch * reach_m;
}

// The position of a kernel is a mean over its particles; each term moves the kernel rigidly with that
// particle.
float particle_reach_m(const RestBody& rest, const KernelBindings& bindings) {
  float reach_m = 0;
  for (size_t k = 0; k < bindings.kernels.size(); ++k) {
    const KernelBinding& binding = bindings.kernels[k];
    float offset_m = 0;
    for (size_t i = 0; i < binding.drivers.size() && binding.weights[i] > 0.0f; ++i)
      offset_m =
          std::max(offset_m, (bindings.rest_positions_m[k] - rest.particles_m[binding.drivers[i]]).norm());
    reach_m = std::max(reach_m, offset_m + extent_m(bindings.rest_covariances_m2[k]));
  }
  return reach_m;
}

}  // namespace

KernelReach kernel_reach(const RestBody& rest, const KernelBindings& bindings) {
  KernelReach reach;
  if (rest.kind == DriverKind::Lattice) reach.drivers_m = kRounding * lattice_reach_m(rest, bindings);
  if (rest.kind == DriverKind::Particles) reach.drivers_m = kRounding * particle_reach_m(rest, bindings);
  if (rest.kind != DriverKind::Rigid) return reach;
  reach.bodies_m.assign(rest.bodies.size(), -1.0f);  // no kernels
  for (size_t k = 0; k < bindings.kernels.size(); ++k) {
    float& body_m = reach.bodies_m[bindings.kernels[k].drivers[0]];
    body_m = std::max(body_m, kRounding * (bindings.rest_positions_m[k].norm() +
                                           extent_m(bindings.rest_covariances_m2[k])));
  }
  return reach;
}

Eigen::AlignedBox3f box_of_kernels(const KernelReach& reach, const ObjectDrivers& drivers) {
  Eigen::AlignedBox3f box;
  if (drivers.kernels) {
    float extent = 0;
    for (const Eigen::Vector3f& position : drivers.kernels->positions_m) box.extend(position);
    for (const Symmetric3f& covariance : drivers.kernels->covariances_m2)
      extent = std::max(extent, extent_m(covariance));
    const Eigen::Vector3f wide = Eigen::Vector3f::Constant(extent);
    return box.isEmpty() ? box : Eigen::AlignedBox3f(box.min() - wide, box.max() + wide);
  }
  if (drivers.kind == DriverKind::Rigid) {
    for (size_t b = 0; b < reach.bodies_m.size(); ++b) {
      if (reach.bodies_m[b] < 0) continue;
      const Eigen::Vector3f middle = drivers.poses[b].position_m.cast<float>();
      const Eigen::Vector3f wide = Eigen::Vector3f::Constant(reach.bodies_m[b]);
      box.extend(Eigen::AlignedBox3f(middle - wide, middle + wide));
    }
    return box;
  }
  for (const Eigen::Vector3f& position : drivers.positions_m) box.extend(position);
  const Eigen::Vector3f wide = Eigen::Vector3f::Constant(reach.drivers_m);
  return box.isEmpty() ? box : Eigen::AlignedBox3f(box.min() - wide, box.max() + wide);
}

}  // namespace livegs
