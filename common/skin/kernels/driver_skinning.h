// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "core/result.h"
#include "gaussian/posed_kernels.h"
#include "skin/driver_frame.h"
#include "skin/kernels/kernel_bindings.h"
#include "skin/rest_body.h"

// Internal to this room: the implementations of bind_kernels and skin_kernels, one pair per driver kind.

namespace livegs {

// Kernels per block of parallel_for: enough work to hide the overhead, small enough to balance the threads.
inline constexpr size_t kSkinBlock = 2048;

// Particles per kernel: m = 4 in LIVE-GS.
inline constexpr int kParticlesPerKernel = 4;

// Kernels at rest in the object frame.
struct RestKernels {
  std::vector<Eigen::Vector3d> positions_m;
  std::vector<Eigen::Matrix3f> covariances_m2;
};

inline Symmetric3f symmetric_of(const Eigen::Matrix3f& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)};
}

// A S Aᵀ.
inline Symmetric3f transformed(const Eigen::Matrix3f& a, const Symmetric3f& s) {
  const Eigen::Vector3f as0 = a.col(0) * s[0] + a.col(1) * s[1] + a.col(2) * s[2];
  const Eigen::Vector3f as1 = a.col(0) * s[1] + a.col(1) * s[3] + a.col(2) * s[4];
  const Eigen::Vector3f as2 = a.col(0) * s[2] + a.col(1) * s[4] + a.col(2) * s[5];
  const auto entry = [&](int i, int j) { return as0[i] * a(j, 0) + as1[i] * a(j, 1) + as2[i] * a(j, 2); };
  return {entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)};
}

Result<void> bind_lattice(const RestKernels& kernels, const RestBody& rest, KernelBindings& bindings);
Result<void> bind_particles(const RestKernels& kernels, const RestBody& rest, KernelBindings& bindings);
Result<void> bind_rigid(const RestKernels& kernels, const RestBody& rest, KernelBindings& bindings);

// The pose of a rigid body in the form used for skinning.
struct TurnedBody {
  Eigen::Matrix3f world_from_body;
  Eigen::Vector3f position_m;
  Eigen::Matrix3f world_from_object;
  Eigen::Quaternionf world_from_asset;
};
std::vector<TurnedBody> turned_bodies(const RestBody& rest, const ObjectDrivers& drivers);

// Preconditions: as for skin_kernels. `kernels` and `deformation_gradients`, if given, already have the right
// length.
void skin_lattice(const RestBody& rest, const KernelBindings& bindings, const ObjectDrivers& drivers,
                  PosedKernels& kernels, std::vector<Eigen::Matrix3f>* deformation_gradients);
void skin_particles(const RestBody& rest, const KernelBindings& bindings, const ObjectDrivers& drivers,
                    PosedKernels& kernels, std::vector<Eigen::Matrix3f>* deformation_gradients);
void skin_rigid(const RestBody& rest, const KernelBindings& bindings, const ObjectDrivers& drivers,
                PosedKernels& kernels, std::vector<Eigen::Matrix3f>* deformation_gradients);

}  // namespace livegs
