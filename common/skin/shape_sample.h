// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gaussian/gaussian_asset.h"
#include "gaussian/posed_kernels.h"
#include "skin/driver_frame.h"
#include "skin/kernels/kernel_bindings.h"
#include "skin/rest_body.h"

namespace livegs {

// A few kernels of an object that represent its shape: cheap to pose where the kernels themselves are posed
// on a device. Takes about 100 bytes per kernel and a copy of the lattice's terms.
class ShapeSample {
 public:
  static constexpr size_t kMaxKernels = 2048;

  ShapeSample() = default;
  // Every n-th kernel with an opacity of at least 0.3, at most kMaxKernels. `bindings` are of `asset`.
  ShapeSample(const GaussianAsset& asset, const KernelBindings& bindings);

  // Their positions and covariances, with the bits of skin_kernels. Preconditions as there; `rest` is that of
  // the bindings. Drivers that are kernels are copied.
  void pose(const RestBody& rest, const ObjectDrivers& drivers, PosedKernels& kernels) const;

  size_t size() const { return kernels_.size(); }
  std::span<const uint32_t> kernels() const { return kernels_; }  // indices in the asset, ascending
  // Opacity times the number of opaque kernels that each stands for.
  std::span<const float> weights() const { return weights_; }
  std::span<const uint32_t> bodies() const { return bodies_; }  // rigid body of each; 0 for other kinds

 private:
  std::vector<uint32_t> kernels_, bodies_;
  std::vector<float> weights_;
  KernelBindings bindings_;
};

}  // namespace livegs
