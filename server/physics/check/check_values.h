// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "core/pose.h"
#include "core/result.h"
#include "physics/material.h"

// Checks of the values in descriptions of objects. Errors: "object N: FIELD is VALUE; it must be LOW to
// HIGH".

namespace livegs {

std::string object_name(uint32_t object_id);  // "object N"
Error object_error(uint32_t object_id, const std::string& problem);
std::string number_text(double value);

Result<void> check_range(uint32_t id, const char* field, double value, double low, double high);
Result<void> check_positive(uint32_t id, const char* field, double value);
Result<void> check_finite(uint32_t id, const char* field, const Eigen::Vector3d& value);
Result<void> check_pose(uint32_t object_id, const Pose& pose);
Result<void> check_material(uint32_t object_id, const Material& material);
// Of an elastic body.
Result<void> check_stiffness(uint32_t object_id, const Material& material);

}  // namespace livegs

// Returns the error of `expression`, a Result, from this function, which returns a Result.
#define LIVEGS_RETURN_IF_ERROR(expression) \
  if (auto outcome = (expression); !outcome) return outcome.error()
