// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "geometry/mesh/mass_properties.h"
#include "geometry/surface/shape_mesh.h"
#include "physics/world.h"
#include "rates.h"

// Bodies and worlds of the rigid tests, at VR sizes: boxes of 0.1 m unless a test says otherwise.

namespace livegs::rigid_fixtures {

inline constexpr double kGravity = 9.81;
inline constexpr double radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

inline RigidBodyDescription body_of(uint32_t id, TriangleMesh mesh, double mass_kg) {
  RigidBodyDescription description;
  description.object_id = id;
  description.properties = solid_mass_properties(mesh);
  description.mesh = std::move(mesh);
  description.material.behavior = Behavior::Rigid;
  description.material.mass_kg = mass_kg;
  description.material.friction = 0.5;
  description.material.restitution = 0.0;
  return description;
}

inline RigidBodyDescription box_body(uint32_t id, const Eigen::Vector3d& size_m, double mass_kg) {
  return body_of(id, box_mesh(size_m), mass_kg);
}

inline BallDescription ball(uint32_t id, const Eigen::Vector3d& position_m, double radius_m = 0.05,
                            double mass_kg = 0.2) {
  BallDescription description;
  description.object_id = id;
  description.position_m = position_m;
  description.velocity_m_s.setZero();
  description.radius_m = radius_m;
  description.mass_kg = mass_kg;
  description.friction = 0.5;
  description.restitution = 0.0;
  return description;
}

inline Collider floor_plane(double friction = 0.5, double restitution = 0.0) {
  Collider collider{PlaneShape{}, Pose{}, friction, restitution};
  return collider;
}

// A plane through the origin that slopes down towards +x.
inline Collider incline(double angle_rad, double friction) {
  Collider collider{PlaneShape{}, Pose{}, friction, 0.0};
  collider.world_from_collider.orientation = Eigen::AngleAxisd(-angle_rad, Eigen::Vector3d::UnitZ());
  return collider;
}

// A repeatable orientation, different for each number.
inline Eigen::Quaterniond rotation_about(int number) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(
      0.7 * number, Eigen::Vector3d(std::sin(1.0 * number), std::cos(2.0 * number), 0.3).normalized()));
}

inline World world_at(double rate_hz, int substeps, const Eigen::Vector3d& gravity = {0, -kGravity, 0}) {
  WorldSettings settings;
  settings.rate_hz = rate_hz;
  settings.substeps = substeps;
  settings.gravity_m_s2 = gravity;
  return World(settings);
}

inline void run_seconds(World& world, double seconds) {
  const auto ticks = static_cast<int>(std::lround(seconds * world.settings().rate_hz));
  for (int i = 0; i < ticks; ++i) world.step();
}

inline BodyState body_state(const World& world, uint32_t id) {
  for (const BodyState& state : world.bodies()) {
    if (state.object_id == id) return state;
  }
  return {};
}

}  // namespace livegs::rigid_fixtures
