// SPDX-License-Identifier: Apache-2.0
#include "core/math/rotation_between.h"

#include <cmath>

namespace livegs {
namespace {

// Sine of the angle below which directions are opposite. The error is this angle; the axis of smaller ones is
// rounding.
constexpr double kOpposite = 1e-8;

}  // namespace

Eigen::Quaterniond rotation_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d a = from.normalized(), b = to.normalized();
  const Eigen::Vector3d sine_axis = a.cross(b);
  if (a.dot(b) < 0.0 && sine_axis.norm() < kOpposite) {
    const Eigen::Vector3d aside = std::abs(a.z()) < 0.9 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX();
    const Eigen::Vector3d axis = (aside - aside.dot(a) * a).normalized();
    return {0.0, axis.x(), axis.y(), axis.z()};
  }
  const double one_plus_cosine = 0.5 * (a + b).squaredNorm();  // without cancellation at opposite directions
  return Eigen::Quaterniond(one_plus_cosine, sine_axis.x(), sine_axis.y(), sine_axis.z()).normalized();
}

}  // namespace livegs
