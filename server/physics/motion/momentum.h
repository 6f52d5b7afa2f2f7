// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>

// Rigid part of the motion of a set of point masses: mass, centre, momentum, angular momentum and inertia.

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

// Inertia, kg m², of the second moments `second`, sums of mass times r r^T.
Eigen::Matrix3d inertia_of(const Eigen::Matrix3d& second);
Eigen::Matrix3d second_moments_of(const Eigen::Matrix3d& inertia);
// The symmetric map G with G from G = to (the least motion that takes a distribution of mass with one second
// moment to one with the other; Dowson and Landau 1982). Axes in which `from` has none are left out.
Eigen::Matrix3d map_between_moments(const Eigen::Matrix3d& from, const Eigen::Matrix3d& to);

// Angular velocity for the angular momentum `l`. Axes with a negligible moment (all masses on a line) are
// omitted.
Eigen::Vector3d solve_inertia(const Eigen::Matrix3d& inertia, const Eigen::Vector3d& l);

// Rotation factor of `matrix` (polar decomposition; the nearest proper rotation for a flattened or inverted
// matrix). Newton's method from `warm`: Müller et al. 2016, A robust method to extract the rotational part of
// deformations.
Eigen::Quaterniond extract_rotation(const Eigen::Matrix3d& matrix, const Eigen::Quaterniond& warm);

}  // namespace livegs
