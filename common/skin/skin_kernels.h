// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/result.h"
#include "gaussian/gaussian_asset.h"
#include "gaussian/posed_kernels.h"
#include "skin/driver_frame.h"
#include "skin/kernels/kernel_bindings.h"
#include "skin/rest_body.h"

// Moves kernels with drivers. Each frame starts from the rest state, so errors do not accumulate.
//
// Lattice (default): a kernel is embedded in its cell. Its position follows from the eight trilinear weights,
// the deformation gradient F from the same lattice, and its covariance is F Σ Fᵀ with the singular values of
// F clamped. Node gradients are volume-weighted means over the adjacent cells and are interpolated like
// positions. So F has no seam at a cell face, and an affine motion is exact.
//
// A kernel outside all cells has an offset from the nearest point of its cell. The first cell width of the
// offset rotates and stretches with F at that point, the rest with the mean F of the body. Haze thus moves
// with the body, and a fluttering edge does not fling it away. The covariance of such a kernel uses F at the
// nearest point.
//
// Particles: LIVE-GS (Mao et al.), section "Gaussian kernel deformation", eq. 3 to 6: the m = 4 nearest
// particles, inverse-distance weights, translation and recursive slerp; sizes never change.
//
// Rigid: m = 1.

namespace livegs {

// Limits of the stretch of a kernel along any axis, unitless. They prevent needles and vanishing kernels
// where a cell is crushed.
inline constexpr float kMinKernelStretch = 0.25f;
inline constexpr float kMaxKernelStretch = 4.0f;

// Binds each kernel of `asset` to the drivers of `rest`. A kernel outside all lattice cells (haze, floaters)
// is bound to the nearest cell. In a rigid object of several bodies, a kernel is bound to the body with the
// nearest origin. Ties go to the lower index. Fails if `rest` has no driver of its kind, an index out of
// range, a cell that is not a cube of its nodes, or a value that is not finite.
Result<KernelBindings> bind_kernels(const GaussianAsset& asset, const RestBody& rest);

// Computes the kernel poses for `drivers`. Deterministic for any thread count.
// Preconditions: `bindings` came from the same asset and rest; `drivers` has as many drivers as `rest` (use
// check_drivers for received drivers).
// `deformation_gradients`, if given, receives the F used for each covariance (rest object frame to world; for
// a rigid body, F is its rotation).
void skin_kernels(const GaussianAsset& asset, const RestBody& rest, const KernelBindings& bindings,
                  const ObjectDrivers& drivers, PosedKernels& kernels,
                  std::vector<Eigen::Matrix3f>* deformation_gradients = nullptr);

// Checks that drivers fit a rest body: same kind, same counts, all values finite.
Result<void> check_drivers(const RestBody& rest, const ObjectDrivers& drivers);

}  // namespace livegs
