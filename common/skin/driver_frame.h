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

// The representation that moves the kernels of an object.
enum class DriverKind : uint8_t {
  Rigid = 1,      // poses of rigid bodies, one per object or fragment; static objects are rigid and asleep
  Lattice = 2,    // nodes of the lattice that embeds an elastic body
  Particles = 3,  // particles with rotations: the livegs-v1 baseline
};

// Current drivers of one object, in the world frame. Only the arrays of its kind are filled, in the order of
// its RestBody.
struct ObjectDrivers {
  uint32_t object_id = 0;
  DriverKind kind = DriverKind::Rigid;
  uint32_t revision = 0;  // revision of the matching RestBody
  bool asleep = false;
  std::vector<Pose> poses;  // Rigid: world_from_body; the body's origin is its centre of mass
  std::vector<Eigen::Vector3f> positions_m;   // Lattice, Particles
  std::vector<Eigen::Quaternionf> rotations;  // Particles: rotation since rest, world_from_object
  // Lattice: adjacency at rest, used for stream prediction. Null: not available.
  NodeNeighboursPtr neighbours{};
  // The posed kernels themselves, for a kernel stream; null otherwise. If set, the arrays above are empty and
  // `kind` has no meaning. Functions that skin, bind or encode drivers do not accept such objects.
  std::shared_ptr<const PosedKernels> kernels{};
};

// State of all simulated objects at one tick; the only data sent in every frame. The number of a frame is its
// tick; there is no other. It is counted in SceneRun::advance (server/session/simulation/scene_run.cpp), with
// paused ticks; without a session in World::step (server/physics/world/world_step.cpp).
struct DriverFrame {
  uint64_t tick = 0;         // the frame's number; 0 is the start, before any step
  int64_t simulated_ns = 0;  // tick / rate
  std::vector<ObjectDrivers> objects;
};

}  // namespace livegs
