// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "skin/kernels/limit_deformation.h"
#include "skin/skin_kernels.h"

// Inside the room: what skin_kernels and the pass skin_lattice do alike.

namespace livegs {

// Where a node is and how the body deforms there, in the lanes of two AVX registers, or of four vec4
// (skin_lattice_layout.h): x y z 0 | dx/dX 0, then dx/dY 0 | dx/dZ 0, with X Y Z along the lattice's axes.
// One cache line.
struct alignas(64) NodeState {
  Eigen::Array<float, 8, 1> position_and_x;
  Eigen::Array<float, 8, 1> y_and_z;
};
static_assert(sizeof(NodeState) == 64);

// Of each node, for drivers that fit `rest`.
std::vector<NodeState> node_states(const KernelBindings& bindings,
                                   const std::vector<Eigen::Vector3f>& positions_m);

// What the kernels of a body share.
struct LatticeBody {
  Eigen::Matrix3f gradient;  // of the body as a whole, limited
  Eigen::Quaternionf lattice_from_asset;
  float cell_width_m = 0;
};
LatticeBody lattice_body_of(const RestBody& rest, std::span<const NodeState> states);

// Some kernels of a body, a lane each: lanes do not influence one another.
struct LatticeLanes {
  // At rest.
  std::array<uint32_t, kDeformationLanes> cells{};
  std::array<Eigen::Array3f, kDeformationLanes> local;
  std::array<Symmetric3f, kDeformationLanes> rest_covariances_m2;
  // As skinned.
  std::array<Eigen::Vector3f, kDeformationLanes> positions_m;
  std::array<Symmetric3f, kDeformationLanes> covariances_m2;
  std::array<Eigen::Quaternionf, kDeformationLanes> world_from_asset;
  LimitedDeformations deformations;  // world from lattice
};
// The first `count` of them.
void skin_lanes(std::span<const NodeState> states, std::span<const std::array<uint32_t, 8>> cells,
                const LatticeBody& body, LatticeLanes& lanes, size_t count);

}  // namespace livegs
