// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "fuzz/fuzz_target.h"
#include "skin/driver_frame.h"
#include "skin/rest_body.h"

// Moving objects of each kind, and checks of decoded frames, for the targets that read frames.

namespace livegs::fuzz {

inline DriverFrame frame_at(uint64_t tick) {
  const double t = 0.011 * static_cast<double>(tick);
  DriverFrame frame;
  frame.tick = tick;
  frame.simulated_ns = static_cast<int64_t>(tick) * 11'111'111;
  for (uint32_t id = 1; id <= 4; ++id) {
    if (id == 3 && tick % 5 == 0) continue;  // object 3 is missing in every fifth tick
    ObjectDrivers& object = frame.objects.emplace_back();
    object.object_id = 3 * id;
    object.asleep = id == 4 && tick % 3 == 0;
    object.kind = id == 1 ? DriverKind::Lattice : id == 2 ? DriverKind::Particles : DriverKind::Rigid;
    if (object.kind == DriverKind::Rigid) object.revision = tick > 4 ? 1 : 0;
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(3 * t, Eigen::Vector3d(1, id, 2).normalized()));
    for (int i = 0; i < (object.kind == DriverKind::Rigid ? 2 : 12); ++i) {
      if (object.kind == DriverKind::Lattice) {
        static const NodeNeighboursPtr neighbours = [] {
          std::vector<Eigen::Vector3i> places;
          for (int k = 0; k < 12; ++k) places.emplace_back(k & 1, (k >> 1) & 1, k >> 2);
          return find_node_neighbours(std::move(places));
        }();
        object.neighbours = tick % 7 == 0 ? nullptr : neighbours;  // with and without neighbours
      }
      const Eigen::Vector3d at(0.1 * i + 0.2 * std::sin(9 * t + i), id + t, -4.9 * t * t);
      if (object.kind == DriverKind::Rigid) {
        object.poses.push_back({at, turn});
      } else {
        object.positions_m.push_back(at.cast<float>());
        if (object.kind == DriverKind::Particles) object.rotations.push_back(turn.cast<float>());
      }
    }
  }
  return frame;
}

inline void check_finite(const DriverFrame& frame) {
  for (const ObjectDrivers& object : frame.objects) {
    for (const Pose& pose : object.poses) {
      check(pose.position_m.allFinite(), "poses are finite");
      check(std::abs(pose.orientation.norm() - 1.0) < 1e-9, "orientations are unit quaternions");
    }
    for (const Eigen::Vector3f& position : object.positions_m)
      check(position.allFinite(), "positions are finite");
    for (const Eigen::Quaternionf& rotation : object.rotations)
      check(std::abs(rotation.norm() - 1.0f) < 1e-5f, "rotations are unit quaternions");
  }
}

inline std::vector<RestBody> rest_bodies() {
  RestBody rigid;
  for (int i = 0; i < 3; ++i)
    rigid.bodies.push_back(
        {Eigen::Vector3d(i, 0.5, -1), Eigen::Quaterniond(Eigen::AngleAxisd(i, Eigen::Vector3d::UnitX()))});
  RestBody broken = rigid;
  broken.revision = 2;
  broken.kernel_runs = {{0, 5}, {2, 7}, {1, 1}};
  RestBody lattice;
  lattice.kind = DriverKind::Lattice;
  lattice.cell_width_m = 0.1;
  for (int i = 0; i < 12; ++i) lattice.node_coordinates.emplace_back(i & 1, (i >> 1) & 1, i >> 2);
  lattice.cells = {{0, 1, 2, 3, 4, 5, 6, 7}, {4, 5, 6, 7, 8, 9, 10, 11}};
  RestBody filled = lattice;
  filled.cell_fills = {0x123456789ABCDEF0u, 1};
  RestBody particles;
  particles.kind = DriverKind::Particles;
  for (int i = 0; i < 9; ++i) particles.particles_m.emplace_back(0.1f * static_cast<float>(i), 1.0f, -2.0f);
  return {rigid, broken, lattice, filled, particles};
}

}  // namespace livegs::fuzz
