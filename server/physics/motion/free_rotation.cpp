// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/motion/free_rotation.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace livegs {
namespace {

// Rotation of the y-z difference per step.
constexpr double kMaxSplitTurn_rad = 0.05;

}  // namespace

Eigen::Quaterniond rotation_exp(const Eigen::Vector3d& angle_rad) {
  const double half = 0.5 * angle_rad.norm();
  // The series of sin(x)/x avoids cancellation near 0: the next term is below 1e-17 there.
  const double sinc = half > 1e-4 ? std::sin(half) / half : 1.0 - half * half / 6.0;
  Eigen::Quaterniond turn;
  turn.w() = std::cos(half);
  turn.vec() = 0.5 * sinc * angle_rad;
  return turn;
}

Eigen::Matrix3d rotated_tensor(const Eigen::Quaterniond& world_from_body, const Eigen::Matrix3d& tensor) {
  const Eigen::Matrix3d rotation = world_from_body.toRotationMatrix();
  return rotation * tensor * rotation.transpose();
}

PrincipalAxes principal_axes(const Eigen::Matrix3d& inertia) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solved(inertia);
  const Eigen::Vector3d inverse = solved.eigenvalues().cwiseInverse();  // descending
  // The distinct moment is the first or the last one. Columns are permuted cyclically, which keeps the axes
  // right-handed.
  const int first = inverse[0] - inverse[1] > inverse[1] - inverse[2] ? 0 : 2;
  Eigen::Matrix3d axes;
  PrincipalAxes principal;
  for (int i = 0; i < 3; ++i) {
    axes.col(i) = solved.eigenvectors().col((first + i) % 3);
    principal.inverse_moments[i] = inverse[(first + i) % 3];
  }
  if (axes.determinant() < 0.0) axes.col(2) = -axes.col(2);
  principal.body_from_axes = Eigen::Quaterniond(axes).normalized();
  return principal;
}

Eigen::Quaterniond rotate_freely(const Eigen::Quaterniond& orientation, const PrincipalAxes& axes,
                                 const Eigen::Vector3d& momentum, double duration_s) {
  const double reference = axes.inverse_moments.z();
  const double spin = axes.inverse_moments.x() - reference, unlike = axes.inverse_moments.y() - reference;
  const double parts = std::ceil(duration_s * momentum.norm() * std::abs(unlike) / kMaxSplitTurn_rad);
  const int steps = static_cast<int>(std::clamp(parts, 1.0, 64.0));  // a faster turn is not visible
  const double step_s = duration_s / steps;
  const Eigen::Quaterniond ball = rotation_exp(step_s * reference * momentum);
  Eigen::Quaterniond turned = orientation * axes.body_from_axes;
  // Rotates about a body axis at the rate of the momentum along it, which the rotation leaves unchanged.
  const auto turn_about = [&](int axis, double rate_per_momentum) {
    if (rate_per_momentum == 0.0) return;
    const double along = (turned * Eigen::Vector3d::Unit(axis)).dot(momentum);
    turned = turned * rotation_exp(rate_per_momentum * along * Eigen::Vector3d::Unit(axis));
  };
  for (int i = 0; i < steps; ++i) {
    turn_about(1, 0.5 * step_s * unlike);
    turn_about(0, step_s * spin);
    turned = ball * turned;
    turn_about(1, 0.5 * step_s * unlike);
  }
  return (turned * axes.body_from_axes.conjugate()).normalized();
}

}  // namespace livegs
