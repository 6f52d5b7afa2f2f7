// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/world/check_descriptions.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstdio>

namespace livegs {
namespace {

Error refuse(uint32_t object_id, const std::string& what) {
  return invalid_argument("object " + std::to_string(object_id) + ": " + what);
}

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

Result<void> check_range(uint32_t id, const char* field, double value, double low, double high) {
  if (value >= low && value <= high) return {};
  return refuse(id, std::string(field) + " " + number_text(value) + " is outside " + number_text(low) +
                        " to " + number_text(high));
}

Result<void> check_positive(uint32_t id, const char* field, double value) {
  if (value > 0.0 && std::isfinite(value)) return {};
  return refuse(id, std::string(field) + " " + number_text(value) + " is not a positive number");
}

Result<void> check_finite(uint32_t id, const char* field, const Eigen::Vector3d& value) {
  if (value.allFinite()) return {};
  return refuse(id, std::string(field) + " is not finite");
}

Result<void> check_mesh(uint32_t id, const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return refuse(id, "the mesh has no triangles");
  for (const Eigen::Vector3d& vertex : mesh.vertices_m) {
    if (!vertex.allFinite()) return refuse(id, "a vertex of the mesh is not finite");
  }
  for (const auto& triangle : mesh.triangles) {
    for (const uint32_t index : triangle) {
      if (index >= mesh.vertices_m.size())
        return refuse(id, "a triangle of the mesh refers to a missing vertex");
    }
  }
  return {};
}

}  // namespace

#define LIVEGS_TRY(check) \
  if (auto tried = (check); !tried) return tried

Result<void> check_settings(const WorldSettings& settings) {
  if (!settings.gravity_m_s2.allFinite()) return invalid_argument("world: gravity_m_s2 is not finite");
  if (!(settings.rate_hz >= 1.0 && settings.rate_hz <= 1e4)) {
    return invalid_argument("world: rate_hz " + number_text(settings.rate_hz) + " is outside 1 to 10000");
  }
  if (settings.substeps < 1 || settings.substeps > 4096) {
    return invalid_argument("world: substeps " + std::to_string(settings.substeps) + " is outside 1 to 4096");
  }
  return {};
}

Result<void> check_pose(uint32_t object_id, const Pose& pose) {
  LIVEGS_TRY(check_finite(object_id, "position_m", pose.position_m));
  // The tolerance admits quaternions printed with nine digits.
  if (!(std::abs(pose.orientation.norm() - 1.0) < 1e-3)) {
    return refuse(object_id, "orientation is not a unit quaternion");
  }
  return {};
}

Result<void> check_material(uint32_t object_id, const Material& material) {
  LIVEGS_TRY(check_positive(object_id, "mass_kg", material.mass_kg));
  LIVEGS_TRY(check_positive(object_id, "youngs_modulus_pa", material.youngs_modulus_pa));
  LIVEGS_TRY(check_range(object_id, "poisson_ratio", material.poisson_ratio, 0.0, 0.49));
  LIVEGS_TRY(check_range(object_id, "structure_coefficient", material.structure_coefficient, 0.0, 1.0));
  LIVEGS_TRY(check_range(object_id, "plasticity", material.plasticity, 0.0, 1.0));
  LIVEGS_TRY(check_range(object_id, "loss_factor", material.loss_factor, 0.0, 2.0));
  LIVEGS_TRY(check_range(object_id, "friction", material.friction, 0.0, kMaxFriction));
  LIVEGS_TRY(check_range(object_id, "restitution", material.restitution, 0.0, 1.0));
  if (material.behavior == Behavior::Auto)
    return refuse(object_id, "behavior is AUTO; analyse the object first");
  return {};
}

Result<void> check_break_impulse(uint32_t object_id, const Material& material) {
  return check_range(object_id, "break_impulse_n_s", material.break_impulse_n_s, kMinBreakImpulse_n_s,
                     kMaxBreakImpulse_n_s);
}

Result<void> check_rigid(const RigidBodyDescription& description) {
  const uint32_t id = description.object_id;
  LIVEGS_TRY(check_material(id, description.material));
  LIVEGS_TRY(check_pose(id, description.world_from_object));
  LIVEGS_TRY(check_finite(id, "velocity_m_s", description.velocity_m_s));
  LIVEGS_TRY(check_finite(id, "angular_velocity_rad_s", description.angular_velocity_rad_s));
  LIVEGS_TRY(check_mesh(id, description.mesh));
  for (const FrictionBox& one : description.friction_boxes)
    LIVEGS_TRY(check_range(id, "friction_boxes.factor", one.factor, 0.0, kMaxFrictionFactor));
  LIVEGS_TRY(check_finite(id, "centre_of_mass_m", description.properties.centre_of_mass_m));
  const Eigen::Matrix3d& inertia = description.properties.inertia_m2;
  if (!inertia.allFinite()) return refuse(id, "inertia is not finite");
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(inertia, Eigen::EigenvaluesOnly);
  const Eigen::Vector3d moments = solver.eigenvalues();  // ascending
  // The largest moment is at most the sum of the other two; a flat body has equality.
  if (!(moments[0] > 0.0) || moments[2] > 1.001 * (moments[0] + moments[1])) {
    return refuse(id, "inertia is not physical; check that the mesh is closed and oriented outwards");
  }
  return {};
}

Result<void> check_ball(const BallDescription& description) {
  const uint32_t id = description.object_id;
  LIVEGS_TRY(check_finite(id, "position_m", description.position_m));
  LIVEGS_TRY(check_finite(id, "velocity_m_s", description.velocity_m_s));
  LIVEGS_TRY(check_positive(id, "radius_m", description.radius_m));
  LIVEGS_TRY(check_positive(id, "mass_kg", description.mass_kg));
  LIVEGS_TRY(check_range(id, "friction", description.friction, 0.0, kMaxFriction));
  LIVEGS_TRY(check_range(id, "restitution", description.restitution, 0.0, 1.0));
  return {};
}

Result<void> check_elastic(const ElasticBodyDescription& description) {
  const uint32_t id = description.object_id;
  LIVEGS_TRY(check_material(id, description.material));
  LIVEGS_TRY(check_pose(id, description.world_from_object));
  LIVEGS_TRY(check_finite(id, "velocity_m_s", description.velocity_m_s));
  LIVEGS_TRY(check_finite(id, "angular_velocity_rad_s", description.angular_velocity_rad_s));
  return {};
}

#undef LIVEGS_TRY

}  // namespace livegs
