// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "gaussian/gaussian_asset.h"

namespace livegs {

// Joins each kernel to its nearest neighbours with touching ellipsoids. Computed once per room, in the
// background; it stays valid after parts are divided or joined. Any thread may read it.
class KernelGraph {
 public:
  static constexpr size_t kEdges = 10;  // of a kernel

  // `label` has the part of each kernel, 0 for the room, kNotJoined for kernels without edges; with the unit
  // vector `up` it decides on which side of a kernel its part is. An edge is weak between kernels that are
  // far apart for their surroundings, of other colours, or that meet in a concave edge. Deterministic.
  KernelGraph(const GaussianAsset& asset, std::span<const uint16_t> label, const Eigen::Vector3d& up);
  static constexpr uint16_t kNotJoined = 0xffff;

  size_t size() const { return weights_.size() / kEdges; }
  // Neighbours of a kernel, the kernel itself where there are fewer, and the weights of the edges, 0 to 1.
  std::span<const uint32_t> neighbours(size_t k) const { return {&neighbours_[kEdges * k], kEdges}; }
  std::span<const float> weights(size_t k) const { return {&weights_[kEdges * k], kEdges}; }

 private:
  std::vector<uint32_t> neighbours_;
  std::vector<float> weights_;
};

}  // namespace livegs
