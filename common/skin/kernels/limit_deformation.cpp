// SPDX-License-Identifier: Apache-2.0
// Polar factor: Newton's iteration, Higham 1986, Computing the polar decomposition. Singular values: Hestenes
// 1958, Inversion of matrices by biorthogonalization.
#include "skin/kernels/limit_deformation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "skin/kernels/skin_lattice_layout.h"
#include "skin/skin_kernels.h"

namespace livegs {
namespace {

using Lanes = Eigen::Array<float, kDeformationLanes, 1>;

struct LaneVector {
  Lanes x, y, z;
};

LaneVector cross(const LaneVector& a, const LaneVector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

Lanes dot(const LaneVector& a, const LaneVector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// Newton's iteration maps a singular value s to (s + 1/s) / 2. From the ends of the range, 4 and 0.25, it
// gives 2.1, 1.3, 1.03, 1.0006, 1 + 2e-7; one more step reaches float precision.
constexpr int kNewtonSteps = 6;
static_assert(kMaxKernelStretch <= 4.0f && kMinKernelStretch >= 0.25f);
static_assert(kMaxKernelStretch == kKernelStretchLimit && kMinKernelStretch * kKernelStretchLimit == 1.0f);

// Sweeps from columns at any angles. Convergence is quadratic; the limit leaves a margin.
constexpr int kJacobiSweeps = 6;

// Minimum stretch with a reliable direction. Node positions are floats some metres from the origin, so a
// smaller stretch of a 10 mm cell is rounding error.
constexpr float kMinKnownStretch = 1e-4f;

// Squared cosine of columns that are orthogonal to rounding.
constexpr float kOrthogonalCosine_squared = 1e-14f;

// Lengths that differ by less than 5e-5 count as equal, and equal columns count as orthogonal within 1e-5
// rad. Both exceed the rounding of divisions and roots, which devices may choose (Vulkan: 2.5 ULP), and of
// node positions. Otherwise rounding would choose the axis of a mirrored cell, whose stretches are equal, and
// each device would choose another one. The error of the gradient is at most 1e-5 of its norm.
constexpr float kEqualRatio_squared = 1.0001f;
constexpr float kEqualCosine_squared = 1e-10f;

struct Vector {
  float x, y, z;
};

Vector operator*(float s, const Vector& v) { return {s * v.x, s * v.y, s * v.z}; }
Vector operator+(const Vector& a, const Vector& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vector operator-(const Vector& a, const Vector& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
float dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vector cross(const Vector& a, const Vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Vector unit(const Vector& v) { return (1.0f / std::sqrt(dot(v, v))) * v; }

// One-sided Jacobi step: rotates two columns of F V, and those of V with them, until they are orthogonal.
void part_columns(Vector (&b)[3], Vector (&v)[3], int p, int q) {
  const float alpha = dot(b[p], b[p]), beta = dot(b[q], b[q]), gamma = dot(b[p], b[q]);
  const bool equal = alpha <= kEqualRatio_squared * beta && beta <= kEqualRatio_squared * alpha;
  if (gamma * gamma <= (equal ? kEqualCosine_squared : kOrthogonalCosine_squared) * alpha * beta) return;
  const float zeta = (beta - alpha) / (2.0f * gamma);
  const float magnitude = 1.0f / (std::abs(zeta) + std::sqrt(1.0f + zeta * zeta));
  const float t = zeta < 0.0f ? -magnitude : magnitude;
  const float c = 1.0f / std::sqrt(1.0f + t * t), s = c * t;
  const Vector b_p = b[p], v_p = v[p];
  b[p] = c * b_p - s * b[q];
  b[q] = s * b_p + c * b[q];
  v[p] = c * v_p - s * v[q];
  v[q] = s * v_p + c * v[q];
}

void order_columns(Vector (&b)[3], Vector (&v)[3], int p, int q) {  // the longer first
  if (dot(b[q], b[q]) <= kEqualRatio_squared * dot(b[p], b[p])) return;
  std::swap(b[p], b[q]);
  std::swap(v[p], v[q]);
}

// CPU function of limit_by_singular_values in limit_deformation.glsl, step by step. Uses plain floats, so
// that both choose the same result if rounding decides how a cell collapses.
void limit_by_singular_values(Eigen::Matrix3f& gradient, Eigen::Quaternionf& rotation) {
  const float scale = gradient.cwiseAbs().maxCoeff();
  if (scale < kMinKnownStretch) {
    gradient = kMinKernelStretch * Eigen::Matrix3f::Identity();
    rotation.setIdentity();
    return;
  }
  Vector b[3], v[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int c = 0; c < 3; ++c) b[c] = {gradient(0, c) / scale, gradient(1, c) / scale, gradient(2, c) / scale};
  const Vector f[3] = {b[0], b[1], b[2]};
  for (int sweep = 0; sweep < kJacobiSweeps; ++sweep) {
    part_columns(b, v, 0, 1);
    part_columns(b, v, 0, 2);
    part_columns(b, v, 1, 2);
  }
  order_columns(b, v, 0, 1);
  order_columns(b, v, 1, 2);
  order_columns(b, v, 0, 1);
  v[0] = unit(v[0]);
  v[1] = unit(v[1] - dot(v[0], v[1]) * v[0]);
  v[2] = cross(v[0], v[1]);

  // Left singular vectors. If the body is flattened to a plane, the third axis is the normal of the plane. If
  // it is flattened to a line, the rotation is the shortest one that follows the line.
  Vector u[3];
  u[0] = unit(b[0]);
  const Vector second = b[1] - dot(u[0], b[1]) * u[0];
  const float second_length = std::sqrt(dot(second, second));
  if (scale * second_length > kMinKnownStretch) {
    u[1] = (1.0f / second_length) * second;
  } else {
    const float along = 1.0f + dot(v[0], u[0]);
    const Vector turned = along > 1e-3f ? v[1] - (dot(u[0], v[1]) / along) * (u[0] + v[0]) : v[1];
    u[1] = unit(turned - dot(u[0], turned) * u[0]);
  }
  u[2] = cross(u[0], u[1]);
  // Negative if the gradient is inverted.
  const float third = dot(u[2], v[2].x * f[0] + v[2].y * f[1] + v[2].z * f[2]);

  const float sigma[3] = {scale * std::sqrt(dot(b[0], b[0])), scale * second_length, scale * third};
  gradient.setZero();
  Eigen::Matrix3f turn = Eigen::Matrix3f::Zero();
  for (int i = 0; i < 3; ++i) {
    const float stretch = std::clamp(sigma[i], kMinKernelStretch, kMaxKernelStretch);
    const Eigen::Vector3f left(u[i].x, u[i].y, u[i].z), right(v[i].x, v[i].y, v[i].z);
    gradient += stretch * left * right.transpose();
    turn += left * right.transpose();
  }
  rotation = Eigen::Quaternionf(turn).normalized();
}

// Whether all stretches are certainly in range, of a squared norm |F|² and a determinant. |F|² bounds the
// largest singular value from above; since s1 s2 <= (s1² + s2²) / 2, s3 >= 2 det F / |F|². NaN and infinity
// fail the comparisons.
template <class Answer, class Real>
Answer is_within(const Real& norm_squared, const Real& determinant) {
  return norm_squared <= kMaxKernelStretch * kMaxKernelStretch &&
         2.0f * determinant >= kMinKernelStretch * norm_squared && determinant > 0.0f;
}

}  // namespace

void limit_gradient(Eigen::Matrix3f& gradient) {
  Vector column[3];
  for (int c = 0; c < 3; ++c) column[c] = {gradient(0, c), gradient(1, c), gradient(2, c)};
  const float determinant = dot(column[0], cross(column[1], column[2]));
  const float norm_squared =
      dot(column[0], column[0]) + dot(column[1], column[1]) + dot(column[2], column[2]);
  if (is_within<bool>(norm_squared, determinant)) return;
  if (!std::isfinite(norm_squared)) {
    gradient.setIdentity();
    return;
  }
  Eigen::Quaternionf rotation;
  limit_by_singular_values(gradient, rotation);
}

void limit_deformations(LimitedDeformations& deformations) {
  // Columns of the gradients, one gradient per lane.
  LaneVector column[3];
  for (int lane = 0; lane < kDeformationLanes; ++lane) {
    const float* entries = deformations.gradients[lane].data();
    for (int c = 0; c < 3; ++c) {
      column[c].x[lane] = entries[3 * c];
      column[c].y[lane] = entries[3 * c + 1];
      column[c].z[lane] = entries[3 * c + 2];
    }
  }
  LaneVector cofactor[3] = {cross(column[1], column[2]), cross(column[2], column[0]),
                            cross(column[0], column[1])};
  Lanes determinant = dot(column[0], cofactor[0]);

  const Lanes norm_squared =
      dot(column[0], column[0]) + dot(column[1], column[1]) + dot(column[2], column[2]);
  const auto within = is_within<Eigen::Array<bool, kDeformationLanes, 1>>(norm_squared, determinant);

  for (int step = 0; step < kNewtonSteps; ++step) {
    const Lanes inverse = 0.5f / determinant;
    for (int c = 0; c < 3; ++c) {
      column[c] = {0.5f * column[c].x + cofactor[c].x * inverse, 0.5f * column[c].y + cofactor[c].y * inverse,
                   0.5f * column[c].z + cofactor[c].z * inverse};
    }
    if (step + 1 == kNewtonSteps) break;
    cofactor[0] = cross(column[1], column[2]);
    cofactor[1] = cross(column[2], column[0]);
    cofactor[2] = cross(column[0], column[1]);
    determinant = dot(column[0], cofactor[0]);
  }

  for (int lane = 0; lane < kDeformationLanes; ++lane) {
    if (within[lane]) {
      Eigen::Matrix3f rotation;
      for (int c = 0; c < 3; ++c) rotation.col(c) << column[c].x[lane], column[c].y[lane], column[c].z[lane];
      deformations.rotations[lane] = Eigen::Quaternionf(rotation).normalized();
    } else if (std::isfinite(norm_squared[lane])) {
      limit_by_singular_values(deformations.gradients[lane], deformations.rotations[lane]);
    } else {
      deformations.gradients[lane].setIdentity();
      deformations.rotations[lane].setIdentity();
    }
  }
}

}  // namespace livegs
