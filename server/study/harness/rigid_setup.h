// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "study/harness/setup.h"

// Setup and outcome of a rigid scene. Scenes are numbered as in the project's test catalogue: 2 incline, 3
// stopping, 6 rolling box, 8 pendulum, 9 tumbling, 13 stack, 14 heavy on light, 15 chain, 16 dominoes, 19
// overlap, 29 sphere on a soft block. Breaking has no number.

namespace livegs::study {

enum class RigidEngine {
  Livegs,
  Bullet,    // Bullet 3: sequential impulse, 10 iterations, single precision
  OdeQuick,  // Open Dynamics Engine: successive over-relaxation, 20 iterations
  Ode,       // the same with its exact complementarity solver
};

// "livegs", "bullet", "ode quick", "ode"
std::string engine_name(RigidEngine engine);

struct RigidSetup {
  RigidEngine engine = RigidEngine::Livegs;
  double rate_hz = 60.0;   // frames per second
  int substeps = 4;        // per frame; peers take steps of the same length
  double parameter = 0.0;  // varied by the scene; see each scene
};

enum class RunEnd { Ok, Fell, Exploded, NonFinite };
// "ok", "fell", "exploded", "nan"
const char* name_of(RunEnd end);

struct RigidOutcome {
  std::vector<Measurement> measurements;
  Cost cost;                // `substeps` are those of the scene
  size_t bodies = 0;        // dynamic bodies
  RunEnd end = RunEnd::Ok;  // if not Ok, the errors are infinite

  const Measurement& operator[](const std::string& quantity) const;  // precondition: it exists
};

}  // namespace livegs::study
