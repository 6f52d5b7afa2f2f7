// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "gaussian/posed_kernels.h"
#include "skin/driver_frame.h"

namespace livegs {

// The binding of one kernel to the drivers of its object. Computed once, from the rest state, by
// bind_kernels.
struct KernelBinding {
  // Lattice: [0] is the cell. Particles: the four nearest. Rigid: [0] is the body
  std::array<uint32_t, 4> drivers{};
  // Lattice: [0..2] local coordinates, 0..1 inside the cell. Particles: sum to 1
  std::array<float, 4> weights{};
};

// One term of the gradient of a lattice node: column `axis` += weight_per_m * (neighbour position - node
// position).
struct NodeGradientTerm {
  uint32_t neighbour = 0;
  uint32_t axis = 0;
  float weight_per_m = 0.0f;
};

// Bindings and derived rest data of all kernels. The data are precomputed because binding a kernel costs much
// more than skinning it, mostly for its covariance.
struct KernelBindings {
  DriverKind kind = DriverKind::Rigid;
  std::vector<KernelBinding> kernels;

  // Rest covariance of each kernel. Lattice: in the axes of the lattice. Particles: in the object frame.
  // Rigid: in the frame of its body.
  std::vector<Symmetric3f> rest_covariances_m2;
  // Particles and Rigid, in the same frames; empty for Lattice
  std::vector<Eigen::Vector3f> rest_positions_m;

  // Lattice: the terms of node n are node_terms[node_terms_begin[n]] up to node_terms_begin[n + 1].
  std::vector<NodeGradientTerm> node_terms;
  std::vector<uint32_t> node_terms_begin;
};

}  // namespace livegs
