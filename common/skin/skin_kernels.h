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

// Kernels follow drivers. Always from rest, never from frame to frame, so nothing drifts.
//
// Lattice (default): a kernel rides in its cell; position by the eight trilinear weights, the deformation
// gradient F from the same lattice, covariance F Σ Fᵀ with singular values of F clamped. Node gradients are
// the volume-weighted means of the cells around them and are interpolated like positions, so F has no seam at
// a cell face and an affine motion is exact. A kernel outside every cell stands at an offset from the nearest
// point of its cell: the first cell width of the offset turns and stretches with F at that point, the rest
// with the mean F of the body, so that haze moves with the body and a fluttering edge does not fling it. Its
// own F is the one at that point. Particles: LIVE-GS (Mao et al.), section "Gaussian kernel deformation", eq.
// 3 to 6: the m = 4 nearest particles, inverse-distance weights, translation plus recursive slerp; sizes
// never change. Rigid: m = 1.

namespace livegs {

// How far F may stretch or shrink a kernel along any axis before it is clamped: keeps needles and vanishing
// kernels out of a picture where a cell is crushed. Unitless.
inline constexpr float kMinKernelStretch = 0.25f;
inline constexpr float kMaxKernelStretch = 4.0f;

// Ties each kernel of `asset` to the drivers of `rest`. A kernel outside every lattice cell (haze, floaters)
// rides in the nearest one. In a rigid object of several bodies a kernel rides in the body whose origin is
// nearest. Ties go to the lower index. Fails if `rest` has no driver of its kind, an index out of range, a
// cell that is not a cube of its nodes, or a value that is not finite.
Result<KernelBindings> bind_kernels(const GaussianAsset& asset, const RestBody& rest);

// Writes where the kernels are for `drivers`. Deterministic for any thread count.
// Preconditions: `bindings` came from the same asset and rest; `drivers` has as many drivers as `rest`
// (check_drivers says so for drivers from a wire).
// `deformation_gradients`, if given, receives the very F each covariance was made with (rest object frame to
// world, so a turned rigid body has F = its rotation).
void skin_kernels(const GaussianAsset& asset, const RestBody& rest, const KernelBindings& bindings,
                  const ObjectDrivers& drivers, PosedKernels& kernels,
                  std::vector<Eigen::Matrix3f>* deformation_gradients = nullptr);

// Whether drivers fit a rest body: the same kind, the same counts, all finite.
Result<void> check_drivers(const RestBody& rest, const ObjectDrivers& drivers);

}  // namespace livegs
