// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "core/pose.h"
#include "skin/driver_frame.h"

namespace livegs {

// What an object looks like at rest, as far as skinning needs to know: sent to a client once, when it joins
// (and again when the object breaks). Server and client bind the same kernels to the same RestBody with the
// same code, so bindings themselves never travel.
//
// The object frame is the asset scaled to metres and turned +Y up: the frame of regions and force points in
// scenes.
struct RestBody {
  DriverKind kind = DriverKind::Rigid;
  uint32_t revision = 0;  // counts how often the object has broken; drivers name the one they go with
  Similarity object_from_asset;

  // Rigid: object_from_body of each body, in the order of ObjectDrivers::poses.
  std::vector<Pose> bodies;
  // Rigid, once it is broken: which body the asset's kernels go with, in their order. Else empty, and a
  // kernel goes with the nearest body.
  struct KernelRun {
    uint32_t body = 0, count = 0;
  };
  std::vector<KernelRun> kernel_runs;

  // Lattice: cubic cells of width cell_width_m, laid along the axes of object_from_lattice. Node n stands at
  // object_from_lattice * (cell_width_m * node_coordinates[n]). Corner c of a cell is node cells[i][c], where
  // bit 0 of c is +x, bit 1 +y, bit 2 +z.
  Pose object_from_lattice;
  double cell_width_m = 0.0;
  std::vector<Eigen::Vector3i> node_coordinates;
  std::vector<std::array<uint32_t, 8>> cells;
  // Where the material of each cell is (cell_fill.h), if several cells or nodes stand at one place: parts of
  // the object that touch only in the picture have cells and nodes of their own. Else empty.
  std::vector<uint64_t> cell_fills;

  // Particles: rest positions in the object frame.
  std::vector<Eigen::Vector3f> particles_m;
};

}  // namespace livegs
