// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/check/check_values.h"

#include <cmath>

#include "core/text/format_text.h"
#include "physics/surface_friction.h"

namespace livegs {

std::string object_name(uint32_t object_id) { return "object " + std::to_string(object_id); }

Error object_error(uint32_t object_id, const std::string& problem) {
  return invalid_argument(object_name(object_id) + ": " + problem);
}

std::string number_text(double value) { return format_text("%g", value); }

Result<void> check_range(uint32_t id, const char* field, double value, double low, double high) {
  if (value >= low && value <= high) return {};
  return object_error(id, std::string(field) + " is " + number_text(value) + "; it must be " +
                              number_text(low) + " to " + number_text(high));
}

Result<void> check_positive(uint32_t id, const char* field, double value) {
  if (value > 0.0 && std::isfinite(value)) return {};
  return object_error(id, std::string(field) + " is " + number_text(value) + "; it must be above 0");
}

Result<void> check_finite(uint32_t id, const char* field, const Eigen::Vector3d& value) {
  if (value.allFinite()) return {};
  return object_error(id, std::string(field) + " is not finite; check the input");
}

Result<void> check_pose(uint32_t object_id, const Pose& pose) {
  LIVEGS_RETURN_IF_ERROR(check_finite(object_id, "position_m", pose.position_m));
  // The tolerance admits quaternions printed with nine digits.
  if (!(std::abs(pose.orientation.norm() - 1.0) < 1e-3)) {
    return object_error(object_id, "orientation is not a unit quaternion; normalise it");
  }
  return {};
}

Result<void> check_material(uint32_t object_id, const Material& material) {
  LIVEGS_RETURN_IF_ERROR(check_positive(object_id, "mass_kg", material.mass_kg));
  LIVEGS_RETURN_IF_ERROR(check_positive(object_id, "youngs_modulus_pa", material.youngs_modulus_pa));
  LIVEGS_RETURN_IF_ERROR(check_range(object_id, "poisson_ratio", material.poisson_ratio, 0.0, 0.49));
  LIVEGS_RETURN_IF_ERROR(
      check_range(object_id, "structure_coefficient", material.structure_coefficient, 0.0, 1.0));
  LIVEGS_RETURN_IF_ERROR(check_range(object_id, "plasticity", material.plasticity, 0.0, 1.0));
  LIVEGS_RETURN_IF_ERROR(check_range(object_id, "loss_factor", material.loss_factor, 0.0, 2.0));
  LIVEGS_RETURN_IF_ERROR(check_range(object_id, "friction", material.friction, 0.0, kMaxFriction));
  LIVEGS_RETURN_IF_ERROR(check_range(object_id, "restitution", material.restitution, 0.0, 1.0));
  if (material.behavior == Behavior::Auto)
    return object_error(object_id, "behavior is AUTO; analyse the object first");
  return {};
}

Result<void> check_stiffness(uint32_t object_id, const Material& material) {
  return check_positive(object_id, "youngs_modulus_pa times structure_coefficient",
                        material.effective_youngs_modulus_pa());
}

}  // namespace livegs
