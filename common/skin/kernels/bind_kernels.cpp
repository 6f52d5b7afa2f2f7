// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <string>

#include "core/parallel_for.h"
#include "skin/kernels/driver_skinning.h"
#include "skin/skin_kernels.h"

namespace livegs {
namespace {

// Upper limit of a standard deviation, m. Prevents covariance overflow: exp() of a finite log-scale may be
// infinite.
constexpr double kMaxStandardDeviation_m = 1e6;

Result<void> check_similarity(const Similarity& object_from_asset) {
  const bool finite = std::isfinite(object_from_asset.scale) &&
                      object_from_asset.rotation.coeffs().allFinite() &&
                      object_from_asset.translation_m.allFinite();
  if (!finite || object_from_asset.scale <= 0.0) {
    return invalid_argument("rest body: object_from_asset must have a positive scale and finite values");
  }
  return {};
}

Result<RestKernels> place_at_rest(const GaussianAsset& asset, const Similarity& object_from_asset) {
  RestKernels kernels;
  kernels.positions_m.resize(asset.size());
  kernels.covariances_m2.resize(asset.size());
  parallel_for(asset.size(), kSkinBlock, [&](size_t begin, size_t end) {
    for (size_t k = begin; k < end; ++k) {
      kernels.positions_m[k] = object_from_asset * asset.positions[k].cast<double>();
      const Eigen::Matrix3d axes =
          (object_from_asset.rotation * asset.rotations[k].cast<double>()).toRotationMatrix();
      const Eigen::Array3d deviation_m =
          (asset.log_scales[k].cast<double>().array().exp() * object_from_asset.scale)
              .min(kMaxStandardDeviation_m);
      const Eigen::Matrix3d scaled = axes * deviation_m.matrix().asDiagonal();
      kernels.covariances_m2[k] = (scaled * scaled.transpose()).cast<float>();
    }
  });
  for (size_t k = 0; k < asset.size(); ++k) {
    if (!kernels.positions_m[k].cast<float>().allFinite() || !kernels.covariances_m2[k].allFinite()) {
      return invalid_argument("kernel " + std::to_string(k) +
                              ": position or covariance is not finite in metres");
    }
  }
  return kernels;
}

}  // namespace

Result<KernelBindings> bind_kernels(const GaussianAsset& asset, const RestBody& rest) {
  if (Result<void> checked = check_similarity(rest.object_from_asset); !checked) return checked.error();
  Result<RestKernels> kernels = place_at_rest(asset, rest.object_from_asset);
  if (!kernels) return kernels.error();

  KernelBindings bindings;
  bindings.kind = rest.kind;
  bindings.kernels.resize(asset.size());
  bindings.rest_covariances_m2.resize(asset.size());
  Result<void> bound = [&]() -> Result<void> {
    switch (rest.kind) {
      case DriverKind::Rigid:
        return bind_rigid(*kernels, rest, bindings);
      case DriverKind::Lattice:
        return bind_lattice(*kernels, rest, bindings);
      case DriverKind::Particles:
        return bind_particles(*kernels, rest, bindings);
    }
    return invalid_argument("rest body: kind " + std::to_string(static_cast<int>(rest.kind)) + " is unknown");
  }();
  if (!bound) return bound.error();
  return bindings;
}

}  // namespace livegs
