// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <memory>

#include "gaussian/posed_kernels.h"
#include "splat/camera.h"

// Kernels for tests and benchmarks of drawing, identical on every machine.

namespace livegs::synthetic {

// SplitMix64 (Steele et al. 2014); the distributions of the standard library differ between implementations.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}
  double uniform(double low = 0.0, double high = 1.0);
  double normal();  // zero mean, unit variance
  Eigen::Vector3d in_ball(double radius);
  Eigen::Quaterniond rotation();

 private:
  uint64_t state_;
};

// An asset and its kernel poses. Covariances follow from rotations and scales; world = asset.
struct Object {
  GaussianAsset asset;
  PosedKernels posed;
  uint32_t id = 0;

  DrawnObject drawn() const { return {&asset, &posed, id}; }
  size_t size() const { return asset.size(); }
};

Symmetric3f covariance(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& standard_deviations_m);

// Appends one kernel of a single colour; `rgb` is its displayed colour.
void add_kernel(Object& object, const Eigen::Vector3d& position_m, const Eigen::Quaterniond& rotation,
                const Eigen::Vector3d& standard_deviations_m, double opacity, const Eigen::Vector3d& rgb);
void add_ball(Object& object, const Eigen::Vector3d& position_m, double standard_deviation_m, double opacity,
              const Eigen::Vector3d& rgb);

// A cloud similar to captured objects: kernels in a shell of radius 0.5 m around the origin, flat, with
// log-normal sizes around `standard_deviation_m` and opacities as after training (many near 1, a tail of
// faint ones).
Object shell(size_t count, int sh_degree, double standard_deviation_m, uint64_t seed);

// The object moved by `motion`: positions, covariances and the frame of the spherical harmonics.
Object moved(const Object& object, const Pose& motion);

}  // namespace livegs::synthetic
