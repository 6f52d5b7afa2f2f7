// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "core/pose.h"
#include "skin/driver_frame.h"

namespace livegs {

// The rest state of an object as needed for skinning. It is sent to a client once, when the client joins, and
// again when the object breaks. Server and client bind the same kernels to the same RestBody with the same
// code, so bindings are never sent.
//
// Object frame: the asset scaled to metres and rotated to +Y up. Regions and force points of scenes use it
// too.
struct RestBody {
  DriverKind kind = DriverKind::Rigid;
  uint32_t revision = 0;  // number of times the object has broken; drivers carry the matching revision
  Similarity object_from_asset;

  // Rigid: object_from_body of each body, in the order of ObjectDrivers::poses.
  std::vector<Pose> bodies;
  // Rigid, after a break: the body of each run of kernels, in the order of the asset. Empty before a break;
  // then each kernel moves with the nearest body.
  struct KernelRun {
    uint32_t body = 0, count = 0;
  };
  std::vector<KernelRun> kernel_runs;

  // Lattice: cubic cells of width cell_width_m along the axes of object_from_lattice. Node n is at
  // object_from_lattice * (cell_width_m * node_coordinates[n]). Corner c of a cell is node cells[i][c], where
  // bit 0 of c is +x, bit 1 +y, bit 2 +z.
  Pose object_from_lattice;
  double cell_width_m = 0.0;
  std::vector<Eigen::Vector3i> node_coordinates;
  std::vector<std::array<uint32_t, 8>> cells;
  // Material distribution of each cell (cell_fill.h) if several cells or nodes share a place: parts of the
  // object that touch only in the image have separate cells and nodes. Empty otherwise.
  std::vector<uint64_t> cell_fills;

  // Particles: rest positions in the object frame.
  std::vector<Eigen::Vector3f> particles_m;
};

}  // namespace livegs
