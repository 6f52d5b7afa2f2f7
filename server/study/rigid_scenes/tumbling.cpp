// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <limits>

#include "study/harness/rigid_scenes.h"
#include "study/harness/rigid_stage.h"

namespace livegs::study {
namespace {

using Eigen::Vector3d;

const Vector3d kMoments(1, 2, 3), kSpin_rad_s(0.01, 10, 0.01);

// Integrates Euler's equations in body axes with fourth-order Runge-Kutta. Returns the first zero crossing of
// the spin about the middle axis.
double first_flip_s() {
  const auto slope = [](const Vector3d& w) {
    return Vector3d((kMoments.y() - kMoments.z()) * w.y() * w.z() / kMoments.x(),
                    (kMoments.z() - kMoments.x()) * w.z() * w.x() / kMoments.y(),
                    (kMoments.x() - kMoments.y()) * w.x() * w.y() / kMoments.z());
  };
  constexpr double h = 1e-4;
  Vector3d w = kSpin_rad_s;
  double time_s = 0.0;
  while (w.y() > 0.0) {
    const Vector3d a = slope(w), b = slope(w + 0.5 * h * a), c = slope(w + 0.5 * h * b), d = slope(w + h * c);
    w += h / 6 * (a + 2 * b + 2 * c + d);
    time_s += h;
  }
  return time_s;
}

}  // namespace

Result<RigidOutcome> tumbling(const RigidSetup& setup) {
  auto made = RigidStage::make(setup, {.gravity_m_s2 = Vector3d::Zero()});
  if (!made) return made.error();
  RigidStage& stage = *made;
  RigidPart part;
  part.size_m = {0.3, 0.2, 0.05};
  part.mass_kg = 100.0;  // large moments for a small box; it has no contacts
  part.moments_kg_m2 = kMoments;
  part.angular_velocity_rad_s = kSpin_rad_s;
  stage.add(part);

  struct State {
    Vector3d spin;  // body axes
    Vector3d momentum;
    double energy;
  };
  const auto state = [&] {
    const RigidMotion& motion = stage.motions()[0];
    const Eigen::Quaterniond& q = motion.world_from_part.orientation;
    const Vector3d spin = q.conjugate() * motion.angular_velocity_rad_s;
    const Vector3d momentum = kMoments.cwiseProduct(spin);
    return State{spin, q * momentum, 0.5 * spin.dot(momentum)};
  };
  const State start{kSpin_rad_s, kMoments.cwiseProduct(kSpin_rad_s),
                    0.5 * kSpin_rad_s.dot(kMoments.cwiseProduct(kSpin_rad_s))};
  double energy = 0.0, momentum = 0.0, before = start.spin.y(),
         flip_s = std::numeric_limits<double>::infinity();
  stage.run(60.0, [&] {
    const State now = state();
    energy = std::max(energy, std::abs(now.energy / start.energy - 1));
    momentum = std::max(momentum, (now.momentum - start.momentum).norm() / start.momentum.norm());
    if (now.spin.y() < 0.0 && before >= 0.0 && !std::isfinite(flip_s)) {
      flip_s = stage.time_s() - stage.frame_s() * now.spin.y() / (now.spin.y() - before);
    }
    before = now.spin.y();
  });
  return stage.finish({absolute("energy", energy, 0.0, 1e-3, "relative"),
                       absolute("momentum", momentum, 0.0, 1e-5, "relative"),
                       relative("flip_time", flip_s, first_flip_s(), 0.02)});
}

}  // namespace livegs::study
