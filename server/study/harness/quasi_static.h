// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "study/harness/stage.h"

namespace livegs::study {

struct QuasiStatic {
  std::function<void(double share)> load;     // called once per frame while share grows from 0 to 1
  std::function<Eigen::Vector2d()> observed;  // two figures; an unused second one is zero
  double period_s = 1.0;                      // period of the slowest excited mode
};

// Applies the load over a period and a half. Then waits until the means of the figures over half a period
// change by less than 1e-4 (relative) twice in a row, and returns them. Means are used because a weakly
// damped body oscillates about its rest.
Eigen::Vector2d load_quasi_statically(Stage& stage, const QuasiStatic& scene);

// Predicted ratio of the body's stiffness to the requested one; at most 1.
double predicted_softness(const Setup& setup, const ElasticBody& body);

// Sets the loss factor that damps the slowest mode about critically. Loss factors are relative to the
// requested stiffness, so the value is corrected for a softer body, which would creep otherwise.
void damp(Stage& stage, double softness);

}  // namespace livegs::study
