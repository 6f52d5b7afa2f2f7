// SPDX-License-Identifier: Apache-2.0
#include "skin/shape_sample.h"

#include <algorithm>

#include "core/assert.h"
#include "gaussian/opacity.h"
#include "skin/kernels/driver_skinning.h"

namespace livegs {
namespace {

constexpr double kOpaque = 0.3;  // fainter kernels are haze and do not define the shape

template <class T>
std::vector<T> chosen(const std::vector<T>& from, std::span<const uint32_t> indices) {
  std::vector<T> some;
  if (from.empty()) return some;
  some.reserve(indices.size());
  for (const uint32_t index : indices) some.push_back(from[index]);
  return some;
}

}  // namespace

ShapeSample::ShapeSample(const GaussianAsset& asset, const KernelBindings& bindings) {
  LIVEGS_ASSERT(bindings.kernels.size() == asset.size());
  std::vector<uint32_t> opaque;
  for (uint32_t k = 0; k < asset.size(); ++k) {
    if (opacity_of_logit(asset.opacity_logits[k]) >= kOpaque) opaque.push_back(k);
  }
  const size_t count = std::min(kMaxKernels, opaque.size());
  const float each = count > 0 ? static_cast<float>(opaque.size()) / static_cast<float>(count) : 0.0f;
  for (size_t i = 0; i < count; ++i) {
    const uint32_t k = opaque[i * opaque.size() / count];
    kernels_.push_back(k);
    weights_.push_back(each * static_cast<float>(opacity_of_logit(asset.opacity_logits[k])));
    bodies_.push_back(bindings.kind == DriverKind::Rigid ? bindings.kernels[k].drivers[0] : 0);
  }
  bindings_.kind = bindings.kind;
  bindings_.kernels = chosen(bindings.kernels, kernels_);
  bindings_.rest_covariances_m2 = chosen(bindings.rest_covariances_m2, kernels_);
  bindings_.rest_positions_m = chosen(bindings.rest_positions_m, kernels_);
  bindings_.node_terms = bindings.node_terms;
  bindings_.node_terms_begin = bindings.node_terms_begin;
}

void ShapeSample::pose(const RestBody& rest, const ObjectDrivers& drivers, PosedKernels& kernels) const {
  if (drivers.kernels) {
    kernels.positions_m = chosen(drivers.kernels->positions_m, kernels_);
    kernels.covariances_m2 = chosen(drivers.kernels->covariances_m2, kernels_);
    kernels.world_from_asset = chosen(drivers.kernels->world_from_asset, kernels_);
    return;
  }
  LIVEGS_ASSERT(bindings_.kind == rest.kind && drivers.kind == rest.kind);
  kernels.resize(size());
  switch (rest.kind) {
    case DriverKind::Rigid:
      return skin_rigid(rest, bindings_, drivers, kernels, nullptr);
    case DriverKind::Lattice:
      return skin_lattice(rest, bindings_, drivers, kernels, nullptr);
    case DriverKind::Particles:
      return skin_particles(rest, bindings_, drivers, kernels, nullptr);
  }
}

}  // namespace livegs
