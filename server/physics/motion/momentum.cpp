// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/motion/momentum.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace livegs {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

Vector3d BodyMomentum::angular_velocity_rad_s() const { return solve_inertia(inertia, angular_momentum); }

BodyMomentum body_momentum(std::span<const Vector3d> positions_m, std::span<const Vector3d> velocities_m_s,
                           std::span<const double> masses_kg) {
  BodyMomentum motion;
  for (size_t i = 0; i < masses_kg.size(); ++i) {
    motion.mass_kg += masses_kg[i];
    motion.centre_m += masses_kg[i] * positions_m[i];
    motion.momentum += masses_kg[i] * velocities_m_s[i];
  }
  motion.centre_m /= motion.mass_kg;
  double xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;
  for (size_t i = 0; i < masses_kg.size(); ++i) {
    const Vector3d r = positions_m[i] - motion.centre_m, mr = masses_kg[i] * r;
    xx += mr.x() * r.x();
    yy += mr.y() * r.y();
    zz += mr.z() * r.z();
    xy += mr.x() * r.y();
    xz += mr.x() * r.z();
    yz += mr.y() * r.z();
    motion.angular_momentum += mr.cross(velocities_m_s[i]);
  }
  motion.inertia << yy + zz, -xy, -xz, -xy, xx + zz, -yz, -xz, -yz, xx + yy;
  return motion;
}

Matrix3d inertia_of(const Matrix3d& second) { return second.trace() * Matrix3d::Identity() - second; }

Matrix3d second_moments_of(const Matrix3d& inertia) {
  return 0.5 * inertia.trace() * Matrix3d::Identity() - inertia;
}

Matrix3d map_between_moments(const Matrix3d& from, const Matrix3d& to) {
  const auto power = [](const Matrix3d& matrix, double exponent) {
    const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(matrix);
    const double least = 1e-9 * std::max(0.0, solver.eigenvalues()[2]);
    Vector3d values = Vector3d::Zero();
    for (int d = 0; d < 3; ++d)
      values[d] = solver.eigenvalues()[d] > least ? std::pow(solver.eigenvalues()[d], exponent) : 0.0;
    return Matrix3d(solver.eigenvectors() * values.asDiagonal() * solver.eigenvectors().transpose());
  };
  const Matrix3d root = power(from, 0.5), inverse_root = power(from, -0.5);
  return inverse_root * power(root * to * root, 0.5) * inverse_root;
}

Vector3d solve_inertia(const Matrix3d& inertia, const Vector3d& l) {
  const double scale = inertia.trace();
  if (!(scale > 0.0)) return Vector3d::Zero();
  const double det = inertia.determinant();
  if (det > 1e-6 * scale * scale * scale) return inertia.inverse() * l;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(inertia);
  Vector3d w = Vector3d::Zero();
  for (int d = 0; d < 3; ++d) {
    if (solver.eigenvalues()[d] < 1e-9 * scale) continue;
    const Vector3d axis = solver.eigenvectors().col(d);
    w += axis * (axis.dot(l) / solver.eigenvalues()[d]);
  }
  return w;
}

Quaterniond extract_rotation(const Matrix3d& matrix, const Quaterniond& warm) {
  const double size = matrix.norm();
  if (!(size > 0.0)) return warm;
  Quaterniond q = warm;
  for (int i = 0; i < 40; ++i) {  // Newton from a close start needs few
    const Matrix3d m = q.toRotationMatrix().transpose() * matrix / size;
    const Vector3d tau(m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1));
    const Matrix3d k = m.trace() * Matrix3d::Identity() - 0.5 * (m + m.transpose());
    // Slender bodies have small determinants: a cord of aspect ratio 16 has 4e-3.
    const bool upright =
        k(0, 0) > 1e-5 && k(0, 0) * k(1, 1) - k(0, 1) * k(0, 1) > 1e-8 && k.determinant() > 1e-12;
    if (!upright && i > 0) {
      // Far from the solution, and possibly slender: use the SVD. A matrix of rank 1 keeps the rotation about
      // its axis.
      const Eigen::JacobiSVD<Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
      if (svd.singularValues()[1] > 1e-5 * svd.singularValues()[0]) {
        Matrix3d u = svd.matrixU();
        if ((u * svd.matrixV().transpose()).determinant() < 0.0) u.col(2) = -u.col(2);
        return Quaterniond(Matrix3d(u * svd.matrixV().transpose())).normalized();
      }
    }
    const Vector3d w = upright ? Vector3d(k.inverse() * tau) : Vector3d(tau / (std::abs(m.trace()) + 1e-3));
    const double angle = w.norm();
    if (angle < 1e-13) break;
    const double bounded = std::min(angle, 0.5);
    q = (q * Quaterniond(Eigen::AngleAxisd(bounded, w / angle))).normalized();
  }
  return q;
}

}  // namespace livegs
