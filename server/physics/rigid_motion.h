// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

// How a free rigid body turns. Angular momentum is constant in the world frame, so it is the state; the angular
// velocity follows from it and the orientation.

namespace livegs {

// The rotation by `angle_rad` (axis times angle), exactly.
Eigen::Quaterniond rotation_exp(const Eigen::Vector3d& angle_rad);

// R A R^T: a tensor in body axes seen in the world's.
Eigen::Matrix3d rotated_tensor(const Eigen::Quaterniond& world_from_body, const Eigen::Matrix3d& tensor);

// The orientation after `duration_s` of free motion with angular momentum `momentum` (world, kg m²/s): implicit
// midpoint, two fixed-point iterations, exponential map. Second order; over 60 s of Dzhanibekov's motion at 240 Hz
// the momentum stays exact and the energy within 1e-3.
Eigen::Quaterniond turned_freely(const Eigen::Quaterniond& orientation, const Eigen::Matrix3d& inverse_inertia_body,
                                 const Eigen::Vector3d& momentum, double duration_s);

}  // namespace livegs
