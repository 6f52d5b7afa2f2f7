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

// Internal to this room: the code shared by skin_kernels and the pass skin_lattice.

namespace livegs {

// Position of a node and deformation of the body there, in the lanes of two AVX registers or four vec4
// (skin_lattice_layout.h): x y z 0 | dx/dX 0, then dx/dY 0 | dx/dZ 0, with X Y Z along the axes of the
// lattice. One cache line.
struct alignas(64) NodeState {
  Eigen::Array<float, 8, 1> position_and_x;
  Eigen::Array<float, 8, 1> y_and_z;
};
static_assert(sizeof(NodeState) == 64);

// The state of each node. Precondition: the drivers fit `rest`.
std::vector<NodeState> node_states(const KernelBindings& bindings,
                                   const std::vector<Eigen::Vector3f>& positions_m);

// Data shared by all kernels of a body.
struct LatticeBody {
  Eigen::Matrix3f gradient;  // mean of the body, limited
  Eigen::Quaternionf lattice_from_asset;
  float cell_width_m = 0;
};
LatticeBody lattice_body_of(const RestBody& rest, std::span<const NodeState> states);

// Kernels of one body, one per lane. Lanes are independent.
struct LatticeLanes {
  // At rest.
  std::array<uint32_t, kDeformationLanes> cells{};
  std::array<Eigen::Array3f, kDeformationLanes> local;
  std::array<Symmetric3f, kDeformationLanes> rest_covariances_m2;
  // Skinned.
  std::array<Eigen::Vector3f, kDeformationLanes> positions_m;
  std::array<Symmetric3f, kDeformationLanes> covariances_m2;
  std::array<Eigen::Quaternionf, kDeformationLanes> world_from_asset;
  LimitedDeformations deformations;  // world from lattice
};
// Moves a kernel outside of its cell from the nearest point of the cell to its place. `beyond`: from that
// point, in cells; `gradient`: limited, there.
void move_beyond_cell(const Eigen::Array3f& beyond, const Eigen::Matrix3f& gradient, const LatticeBody& body,
                      Eigen::Vector3f& position_m);

// Skins the first `count` lanes.
void skin_lanes(std::span<const NodeState> states, std::span<const std::array<uint32_t, 8>> cells,
                const LatticeBody& body, LatticeLanes& lanes, size_t count);

}  // namespace livegs
