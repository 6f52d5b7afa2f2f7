// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/body_region.h"

#include <algorithm>
#include <cmath>

namespace livegs {
namespace {

// 0 before `start`, 1 after `end`; a ramp of zero length is a step.
double ramp(double t, double start, double end) {
  if (t <= start && start < end) return 0.0;
  return t >= end ? 1.0 : (t - start) / (end - start);
}

struct MovedTo {
  const Eigen::Vector3d& rest_m;
  double time_s;

  Eigen::Vector3d operator()(const DisplacementRamp& m) const {
    return rest_m + ramp(time_s, m.start_s, m.end_s) * m.displacement_m;
  }
  Eigen::Vector3d operator()(const AffineRamp& m) const {
    double s = ramp(time_s, m.start_s, m.end_s);
    if (m.return_end_s > m.end_s && time_s > m.end_s) s = 1.0 - ramp(time_s, m.end_s, m.return_end_s);
    const Eigen::Vector3d r = rest_m - m.about_m;
    return rest_m + s * (m.matrix * r - r);
  }
  Eigen::Vector3d operator()(const HalfSinePulse& m) const {
    const double phase = (time_s - m.start_s) / m.width_s;
    if (!(phase > 0.0 && phase < 1.0)) return rest_m;
    return rest_m + std::sin(M_PI * phase) * m.displacement_m;
  }
  Eigen::Vector3d operator()(const ConstantVelocity& m) const {
    return rest_m + std::clamp(time_s - m.start_s, 0.0, std::max(0.0, m.end_s - m.start_s)) * m.velocity_m_s;
  }
};

}  // namespace

Eigen::Vector3d moved_point(const RegionMotion& motion, const Eigen::Vector3d& rest_m, double time_s) {
  return std::visit(MovedTo{rest_m, time_s}, motion);
}

// Every motion is affine in the rest position: if these four points do not move, no point does.
bool moves_between(const RegionMotion& motion, double from_s, double to_s) {
  for (const Eigen::Vector3d& rest_m : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 0, 0),
                                        Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1)}) {
    if (moved_point(motion, rest_m, from_s) != moved_point(motion, rest_m, to_s)) return true;
  }
  return false;
}

BodyRegion fixed_box(const Eigen::Vector3d& min_m, const Eigen::Vector3d& max_m) {
  BodyRegion region;
  region.min_m = min_m;
  region.max_m = max_m;
  region.fixed = true;
  return region;
}

}  // namespace livegs
