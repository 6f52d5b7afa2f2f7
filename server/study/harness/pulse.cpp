// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/harness/pulse.h"

#include <cmath>
#include <limits>

#include "study/harness/block.h"
#include "study/harness/stage.h"

namespace livegs::study {
namespace {

using Eigen::Vector3d;

constexpr double kLength_m = 2.4, kFoot_m = 0.4, kNear_m = 0.3, kFar_m = 0.8;
constexpr double kStrain = 1e-3;  // strain of the pulse: velocity over wave speed

// Finds the time of the maximum of evenly spaced samples: the vertex of the parabola through the three
// samples around it.
class Peak {
 public:
  void sample(double time_s, double value) {
    if (before_ > top_ && before_ >= value && older_ <= before_) {
      const double bend = older_ - 2 * before_ + value;
      const double shift = bend < 0.0 ? 0.5 * (older_ - value) / bend : 0.0;
      top_ = before_ - 0.25 * (older_ - value) * shift;
      at_s_ = before_s_ + shift * (time_s - before_s_);
    }
    older_ = before_;
    before_ = value;
    before_s_ = time_s;
  }
  double value() const { return top_; }
  double at_s() const { return at_s_; }

 private:
  double older_ = 0, before_ = 0, before_s_ = 0, top_ = 0, at_s_ = 0;
};

}  // namespace

Result<Outcome> pulse(const Setup& setup) {
  const double half_m = 0.5 * kBarWidth_m;
  ElasticBodyDescription bar =
      describe_box(setup, {-0.5 * kLength_m, -half_m, -half_m}, {0.5 * kLength_m, half_m, half_m});
  const double wave_m_s = std::sqrt(setup.youngs_modulus_pa / setup.density_kg_m3);
  const double bump_m_s = 2 * kStrain * wave_m_s;
  for (const Vector3d& p : bar.particles.positions_m) {
    const double s = std::cos(M_PI * p.x() / kFoot_m);
    bar.particle_velocities_m_s.push_back(std::abs(p.x()) < 0.5 * kFoot_m ? Vector3d(bump_m_s * s * s, 0, 0)
                                                                          : Vector3d::Zero());
  }
  auto made = Stage::make(setup, bar);
  if (!made) return made.error();
  Stage& stage = *made;

  Peak near, far;
  const auto watch = [&] {
    near.sample(stage.time_s(), stage.body().point_velocity_m_s({kNear_m, 0, 0}).x());
    far.sample(stage.time_s(), stage.body().point_velocity_m_s({kFar_m, 0, 0}).x());
  };
  // Until the first echo of the end could reach the far station; later pulses are not counted.
  const double echo_m = kLength_m - kFar_m - 0.5 * kFoot_m;
  stage.run(echo_m / wave_m_s, nullptr, watch);
  const double taken_s = far.at_s() - near.at_s();
  const double speed = taken_s > 0.0 ? (kFar_m - kNear_m) / taken_s : std::numeric_limits<double>::infinity();
  return stage.finish({relative("speed", speed / wave_m_s, 1.0, 0.1),
                       absolute("height", far.value() / (0.5 * bump_m_s), 1.0, 1.0)});
}

}  // namespace livegs::study
