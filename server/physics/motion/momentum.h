// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>

// The motion of a set of point masses as a whole: what an elastic body shares with a rigid one.

namespace livegs {

struct BodyMomentum {
  double mass_kg = 0.0;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();          // kg m/s
  Eigen::Vector3d angular_momentum = Eigen::Vector3d::Zero();  // kg m²/s, about the centre
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();           // kg m², about the centre

  Eigen::Vector3d velocity_m_s() const { return momentum / mass_kg; }
  Eigen::Vector3d angular_velocity_rad_s() const;
};

BodyMomentum body_momentum(std::span<const Eigen::Vector3d> positions_m,
                           std::span<const Eigen::Vector3d> velocities_m_s,
                           std::span<const double> masses_kg);

// The angular velocity with angular momentum `l`. Turning about an axis that all masses lie on is nothing:
// such directions are left out.
Eigen::Vector3d solve_inertia(const Eigen::Matrix3d& inertia, const Eigen::Vector3d& l);

// The rotation of `matrix` (its polar factor; the nearest upright one for a flattened or inverted matrix),
// starting from `warm`: Newton's form of Müller et al. 2016, A robust method to extract the rotational part
// of deformations.
Eigen::Quaterniond extract_rotation(const Eigen::Matrix3d& matrix, const Eigen::Quaterniond& warm);

}  // namespace livegs
