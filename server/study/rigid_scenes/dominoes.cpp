// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <limits>

#include "study/harness/rigid_scenes.h"
#include "study/harness/rigid_stage.h"

namespace livegs::study {
namespace {

using Eigen::Vector3d;

constexpr int kDominoes = 20, kFirst = 5, kLast = 15;
constexpr double kHeight_m = 0.2, kDominoThick_m = 0.02, kWidth_m = 0.1, kGap_m = 0.05, kDegree = M_PI / 180;
constexpr int kReferenceSubsteps = 256;
// The reference run ends before the fallen dominoes settle.
constexpr double kRun_s = 4.0, kWave_s = 1.5;

// The stage after the run and the wave speed; infinite if they did not fall in order.
struct Wave {
  RigidStage stage;
  double speed_m_s;
};

Result<Wave> run_wave(const RigidSetup& setup, double seconds) {
  auto made = RigidStage::make(setup);
  if (!made) return made.error();
  RigidStage& stage = *made;
  stage.solver().add_floor({}, 0.5);
  for (int i = 0; i < kDominoes; ++i) {
    RigidPart domino;
    domino.size_m = {kDominoThick_m, kHeight_m, kWidth_m};
    domino.mass_kg = 0.24;
    domino.friction = 0.5;
    // the lower edge towards the next one
    const Vector3d foot((kGap_m + kDominoThick_m) * i + 0.5 * kDominoThick_m, 0, 0);
    if (i == 0) domino.world_from_part.orientation = Eigen::AngleAxisd(-10 * kDegree, Vector3d::UnitZ());
    domino.world_from_part.position_m =
        foot + domino.world_from_part.orientation * Vector3d(-0.5 * kDominoThick_m, 0.5 * kHeight_m, 0);
    stage.add(domino);
  }
  const auto tilt_rad = [&](int i) {
    return std::acos(std::min(1.0, (stage.motions()[i].world_from_part.orientation * Vector3d::UnitY()).y()));
  };
  std::vector<double> passed_s(kDominoes, std::numeric_limits<double>::infinity()), before(kDominoes, 0.0);
  constexpr double kTilt = 15 * kDegree;
  stage.run(seconds, [&] {
    for (int i = 0; i < kDominoes; ++i) {
      const double now = tilt_rad(i);
      if (now > kTilt && !std::isfinite(passed_s[i])) {
        passed_s[i] = stage.time_s() - stage.frame_s() * (now - kTilt) / (now - before[i]);
      }
      before[i] = now;
    }
  });
  for (int i = 1; i < kDominoes; ++i) {
    // Fails if a domino stays upright or falls before its neighbour reached it.
    if (stage.ok() && !(passed_s[i] > passed_s[i - 1] && std::isfinite(passed_s[i])))
      stage.mark(RunEnd::Fell);
  }
  return Wave{std::move(stage),
              (kLast - kFirst) * (kGap_m + kDominoThick_m) / (passed_s[kLast] - passed_s[kFirst])};
}

}  // namespace

Result<RigidOutcome> dominoes(const RigidSetup& setup) {
  static const double reference_m_s = [] {
    RigidSetup fine;
    fine.substeps = kReferenceSubsteps;
    auto wave = run_wave(fine, kWave_s);
    return wave && wave->stage.ok() ? wave->speed_m_s : std::numeric_limits<double>::quiet_NaN();
  }();
  auto wave = run_wave(setup, kRun_s);
  if (!wave) return wave.error();
  return wave->stage.finish({relative("wave_speed", wave->speed_m_s, reference_m_s, 0.05)});
}

}  // namespace livegs::study
