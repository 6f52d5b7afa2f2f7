// SPDX-License-Identifier: Apache-2.0
#include "skin/skin_kernels.h"

#include "core/assert.h"
#include "skin/kernels/driver_skinning.h"

namespace livegs {

void skin_kernels(const GaussianAsset& asset, const RestBody& rest, const KernelBindings& bindings,
                  const ObjectDrivers& drivers, PosedKernels& kernels,
                  std::vector<Eigen::Matrix3f>* deformation_gradients) {
  LIVEGS_ASSERT(bindings.kernels.size() == asset.size());
  LIVEGS_ASSERT(bindings.kind == rest.kind && drivers.kind == rest.kind);
  kernels.resize(asset.size());
  if (deformation_gradients) deformation_gradients->resize(asset.size());
  switch (rest.kind) {
    case DriverKind::Rigid:
      return skin_rigid(rest, bindings, drivers, kernels, deformation_gradients);
    case DriverKind::Lattice:
      return skin_lattice(rest, bindings, drivers, kernels, deformation_gradients);
    case DriverKind::Particles:
      return skin_particles(rest, bindings, drivers, kernels, deformation_gradients);
  }
}

}  // namespace livegs
