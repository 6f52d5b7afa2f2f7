// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/elastic_scenes/pendulum.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "study/harness/block.h"
#include "study/harness/stage.h"

namespace livegs::study {
namespace {

using Eigen::Vector3d;

constexpr double kSeconds = 10.0;

}  // namespace

double pendulum_period_s(double hinge_m, double amplitude_rad, double youngs_modulus_pa,
                         double density_kg_m3) {
  const double arm_m = 0.5 * kBarLength_m - hinge_m;
  const double inertia =
      (kBarLength_m * kBarLength_m + kBarWidth_m * kBarWidth_m) / 12 + arm_m * arm_m;  // for 1 kg
  // 2 K(k) / pi = 1 / agm(1, cos(theta0 / 2)) with k = sin(theta0 / 2).
  double a = 1.0, b = std::cos(0.5 * amplitude_rad);
  for (int i = 0; i < 8; ++i) {
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
  }
  const double rigid_s = 2 * M_PI * std::sqrt(inertia / (kGravity_m_s2 * arm_m)) / a;
  // Stretch under its weight: u = (rho g / E)(L x - x²/2). The arm grows by 2/3 rho g L / E and the inertia
  // by 5/4 of that unit, so the period grows by half the difference, 7/24.
  // Bending: the tension rho g A (L - x) couples the swing with the lowest bending mode (hinged and free) of
  // frequency 15.42 / sqrt(12) w / L² sqrt(E / rho). With the ratio of that mode's mean to its root mean
  // square, 0.31, the period grows by 0.096 (g / L) / frequency².
  const double weight = density_kg_m3 * kGravity_m_s2 * kBarLength_m / youngs_modulus_pa;
  const double bending_rad_s = 15.42 / std::sqrt(12.0) * kBarWidth_m / (kBarLength_m * kBarLength_m) *
                               std::sqrt(youngs_modulus_pa / density_kg_m3);
  return rigid_s *
         (1 + 7.0 / 24.0 * weight + 0.096 * kGravity_m_s2 / (kBarLength_m * bending_rad_s * bending_rad_s));
}

Result<Outcome> pendulum(const Setup& given, double amplitude_rad) {
  Setup setup = given;
  setup.spacing_m = kBarWidth_m / 3;
  const double half_m = 0.5 * kBarWidth_m;
  ElasticBodyDescription rod = describe_box(setup, {0, -half_m, -half_m}, {kBarLength_m, half_m, half_m});
  // Particles are half a spacing inside the end, Bullet's nodes on it.
  const double hinge_m = setup.engine == Engine::Bullet ? 0.0 : 0.5 * setup.spacing_m;
  BodyRegion hinge = fixed_box({-1e-6, -1e-3, -1}, {hinge_m + 1e-6, 1e-3, 1});
  hinge.name = "hinge";
  rod.regions.push_back(hinge);
  // Hangs along -y, rotated by the amplitude.
  rod.world_from_object.orientation = Eigen::AngleAxisd(amplitude_rad - M_PI_2, Vector3d::UnitZ());
  auto made = Stage::make(setup, rod);
  if (!made) return made.error();
  Stage& stage = *made;
  stage.gravity_m_s2 = {0, -kGravity_m_s2, 0};

  const Vector3d pivot = rod.world_from_object * Vector3d(hinge_m, 0, 0);
  const double expected_s =
      pendulum_period_s(hinge_m, amplitude_rad, setup.youngs_modulus_pa, setup.density_kg_m3);
  const int every = stage.sampling_interval(expected_s);
  const auto angle = [&] {
    const Vector3d to = stage.body().centre_pose().position_m - pivot;
    return std::atan2(to.x(), -to.y());
  };
  double before = angle(), first_s = -1, last_s = 0, highest = 0, last_highest = 0;
  const double start = before;
  int crossings = 0;
  const auto watch = [&] {
    const double now = angle();
    if ((before < 0.0) != (now < 0.0)) {
      last_s = stage.time_s() - every * stage.substep_s() * now / (now - before);
      if (first_s < 0.0)
        first_s = last_s;
      else
        ++crossings;
      if (highest > 0.0) last_highest = highest;
      highest = 0.0;
    }
    highest = std::max(highest, std::abs(now));
    before = now;
  };
  stage.run(kSeconds, nullptr, watch, every);
  const double period_s =
      crossings > 0 ? 2 * (last_s - first_s) / crossings : std::numeric_limits<double>::infinity();
  // Energy of the last whole swing, extrapolated from its middle to the end at the measured rate of loss.
  const double left = (1 - std::cos(last_highest)) / (1 - std::cos(start));
  const double at_s = std::max(0.1, last_s - 0.25 * std::min(period_s, kSeconds));
  const double lost = 1.0 - std::pow(left, kSeconds / at_s);
  return stage.finish(
      {absolute("energy_lost", lost, 0.0, 0.01), relative("period", period_s, expected_s, 1e-3)});
}

}  // namespace livegs::study
