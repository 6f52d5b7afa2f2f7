// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/harness/quasi_static.h"

#include <algorithm>
#include <cmath>

namespace livegs::study {
namespace {

constexpr double kRampPeriods = 1.5, kWindowPeriods = 0.5, kSettledRelative = 1e-4;
constexpr int kMinRampFrames = 12, kMinWindowFrames = 4, kMaxWindows = 12;

}  // namespace

double predicted_softness(const Setup& setup, const ElasticBody& body) {
  const double reached = body.accuracy().reached_youngs_modulus_pa;
  return reached > 0.0 ? std::clamp(reached / setup.youngs_modulus_pa, 1e-4, 1.0) : 1.0;
}

void damp(Stage& stage, double softness) {
  Material material = stage.body().material();
  material.loss_factor = 2.0 * std::sqrt(softness);
  stage.body().set_material(material);
}

Eigen::Vector2d load_quasi_statically(Stage& stage, const QuasiStatic& scene) {
  const double frame_s = stage.frame_s();
  const int ramp =
      std::max(kMinRampFrames, static_cast<int>(std::ceil(kRampPeriods * scene.period_s / frame_s)));
  for (int i = 1; i <= ramp; ++i) {
    const double s = static_cast<double>(i) / ramp;
    scene.load(s * s * (3 - 2 * s));
    stage.frame();
  }
  const int window =
      std::max(kMinWindowFrames, static_cast<int>(std::ceil(kWindowPeriods * scene.period_s / frame_s)));
  Eigen::Vector2d before = scene.observed();
  int settled = 0;
  for (int w = 0; w < kMaxWindows; ++w) {
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (int i = 0; i < window; ++i) {
      stage.frame();
      mean += scene.observed() / window;
    }
    settled = (mean - before).cwiseAbs().maxCoeff() < kSettledRelative * std::abs(mean[0]) ? settled + 1 : 0;
    before = mean;
    if (settled == 2 || !mean.allFinite()) break;
  }
  return before;
}

}  // namespace livegs::study
