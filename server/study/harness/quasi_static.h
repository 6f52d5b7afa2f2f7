// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "study/harness/stage.h"

namespace livegs::study {

struct QuasiStatic {
  std::function<void(double share)> load;     // called once a frame while share grows from 0 to 1
  std::function<Eigen::Vector2d()> observed;  // two figures, or one and zero
  double period_s = 1.0;                      // of the slowest motion that the load excites
};

// Loads over a period and a half, waits until the means of the figures over half a period stay within 1e-4
// (relative) from one to the next twice, and returns them. Means, because what is little damped swings about
// its rest.
Eigen::Vector2d load_quasi_statically(Stage& stage, const QuasiStatic& scene);

// How far the body says that it is softer than asked for: 1 or less.
double predicted_softness(const Setup& setup, const ElasticBody& body);

// Gives the body the loss factor that damps its slowest motion about critically. Loss factors are relative to
// the stiffness asked for, so a body that shows a softer one would creep.
void damp(Stage& stage, double softness);

}  // namespace livegs::study
