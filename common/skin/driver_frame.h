// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/pose.h"
#include "gaussian/posed_kernels.h"
#include "skin/drivers/node_neighbours.h"

namespace livegs {

// What moves the kernels of an object.
enum class DriverKind : uint8_t {
  Rigid = 1,      // poses of rigid bodies: one, or one a fragment. Static objects are rigid and asleep
  Lattice = 2,    // nodes of the lattice an elastic body is embedded in
  Particles = 3,  // particles with rotations: the livegs-v1 baseline
};

// The drivers of one object now, in the world frame. Only the arrays of its kind are filled, in the order of
// its RestBody.
struct ObjectDrivers {
  uint32_t object_id = 0;
  DriverKind kind = DriverKind::Rigid;
  uint32_t revision = 0;  // of the RestBody these go with
  bool asleep = false;
  std::vector<Pose> poses;  // Rigid: world_from_body; the body's origin is its centre of mass
  std::vector<Eigen::Vector3f> positions_m;   // Lattice, Particles
  std::vector<Eigen::Quaternionf> rotations;  // Particles: world_from_object turn since rest
  // Lattice: who stands beside whom at rest, from which a stream predicts. Null: not told.
  NodeNeighboursPtr neighbours{};
  // The kernels of the asset themselves, of a stream of kernels: then no array above is filled, and `kind`
  // says nothing. Null else. What skins, binds or encodes drivers takes none of these.
  std::shared_ptr<const PosedKernels> kernels{};
};

// Everything the server simulated at one tick; the only thing that crosses the wire every frame.
struct DriverFrame {
  uint64_t tick = 0;         // 0 is the start, before any step
  int64_t simulated_ns = 0;  // tick / rate
  std::vector<ObjectDrivers> objects;
};

}  // namespace livegs
