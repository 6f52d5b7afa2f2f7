// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/world/check_descriptions.h"

#include <Eigen/Eigenvalues>

#include "physics/check/check_values.h"

namespace livegs {
namespace {

Result<void> check_mesh(uint32_t id, const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return object_error(id, "the mesh has no triangles");
  for (const Eigen::Vector3d& vertex : mesh.vertices_m) {
    if (!vertex.allFinite()) return object_error(id, "a vertex of the mesh is not finite");
  }
  for (const auto& triangle : mesh.triangles) {
    for (const uint32_t index : triangle) {
      if (index >= mesh.vertices_m.size())
        return object_error(id, "a triangle of the mesh refers to a missing vertex");
    }
  }
  return {};
}

}  // namespace

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

Result<void> check_break_impulse(uint32_t object_id, const Material& material) {
  return check_range(object_id, "break_impulse_n_s", material.break_impulse_n_s, kMinBreakImpulse_n_s,
                     kMaxBreakImpulse_n_s);
}

Result<void> check_rigid(const RigidBodyDescription& description) {
  const uint32_t id = description.object_id;
  LIVEGS_RETURN_IF_ERROR(check_material(id, description.material));
  LIVEGS_RETURN_IF_ERROR(check_pose(id, description.world_from_object));
  LIVEGS_RETURN_IF_ERROR(check_finite(id, "velocity_m_s", description.velocity_m_s));
  LIVEGS_RETURN_IF_ERROR(check_finite(id, "angular_velocity_rad_s", description.angular_velocity_rad_s));
  LIVEGS_RETURN_IF_ERROR(check_mesh(id, description.mesh));
  for (const FrictionBox& one : description.friction_boxes)
    LIVEGS_RETURN_IF_ERROR(check_range(id, "friction_boxes.factor", one.factor, 0.0, kMaxFrictionFactor));
  LIVEGS_RETURN_IF_ERROR(check_finite(id, "centre_of_mass_m", description.properties.centre_of_mass_m));
  const Eigen::Matrix3d& inertia = description.properties.inertia_m2;
  if (!inertia.allFinite()) return object_error(id, "inertia is not finite");
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(inertia, Eigen::EigenvaluesOnly);
  const Eigen::Vector3d moments = solver.eigenvalues();  // ascending
  // The largest moment is at most the sum of the other two; a flat body has equality.
  if (!(moments[0] > 0.0) || moments[2] > 1.001 * (moments[0] + moments[1])) {
    return object_error(id, "inertia is not physical; check that the mesh is closed and oriented outwards");
  }
  return {};
}

Result<void> check_ball(const BallDescription& description) {
  const uint32_t id = description.object_id;
  LIVEGS_RETURN_IF_ERROR(check_finite(id, "position_m", description.position_m));
  LIVEGS_RETURN_IF_ERROR(check_finite(id, "velocity_m_s", description.velocity_m_s));
  LIVEGS_RETURN_IF_ERROR(check_positive(id, "radius_m", description.radius_m));
  LIVEGS_RETURN_IF_ERROR(check_positive(id, "mass_kg", description.mass_kg));
  LIVEGS_RETURN_IF_ERROR(check_range(id, "friction", description.friction, 0.0, kMaxFriction));
  LIVEGS_RETURN_IF_ERROR(check_range(id, "restitution", description.restitution, 0.0, 1.0));
  return {};
}

}  // namespace livegs
