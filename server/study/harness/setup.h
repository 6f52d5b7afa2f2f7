// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "physics/elastic_body.h"

// What a canonical scene is run with and what comes out of it. Scenes are numbered as in the catalogue of
// tests the project keeps: 8 pendulum, 20 tension, 21 cantilever, 22 torsion, 23 ring-down, 24 squash, 27
// plastic set.

namespace livegs::study {

inline constexpr double kGravity_m_s2 = 9.81;

enum class Engine {
  Cells,
  LivegsV1,
  LivegsV1Steady,
  Bullet,  // deformable bodies of Bullet 3: tetrahedra, corotated linear elasticity, implicit Euler
};

struct Setup {
  Engine engine = Engine::Cells;
  CellsOptions cells{.second_order = true, .compensate = true, .choose = false};
  double rate_hz = 60.0;
  int substeps = 4;             // a frame, of the scene
  double cell_width_m = 0.025;  // 0: the body chooses
  double spacing_m = 0.025;     // of the particles; livegs-v1 has nothing finer
  double youngs_modulus_pa = 1e5;
  double poisson_ratio = 0.3;
  double density_kg_m3 = 1000.0;
};

// Names a curve of the chart: "cells", "cells BDF1", "cells uncompensated", "cells BDF1 uncompensated",
// "cells chosen", "livegs-v1", "livegs-v1 steady", "bullet".
std::string solver_name(const Setup& setup);

// Processor time, of substeps and ends of frames only.
struct Cost {
  double cpu_s = 0.0;
  double wall_s = 0.0;  // of the whole scene, measuring included
  double simulated_s = 0.0;
  uint64_t substeps = 0;  // the body's own
  uint64_t frames = 0;

  double cpu_ns_per_simulated_s() const { return simulated_s > 0.0 ? 1e9 * cpu_s / simulated_s : 0.0; }
};

// One figure of a scene beside what it should be.
struct Measurement {
  std::string quantity;  // "youngs_modulus", "poisson_ratio", "deflection", …
  double measured = 0.0, reference = 0.0;
  double error = 0.0;  // never negative; relative unless the unit says otherwise
  std::string unit;    // of `error`: "relative", "absolute" (of something without a unit), "m", "m/s", …
  double bar = 0.0;    // `error` should not exceed it where the program calls the setting valid
};

struct Outcome {
  std::vector<Measurement> measurements;  // the first is the chart's
  Cost cost;
  ElasticAccuracy accuracy;
  bool finite = true;  // every particle's position at the end; when false the errors are infinite

  const Measurement& operator[](const std::string& quantity) const;  // precondition: it is there
};

// |measured / reference - 1| or |measured - reference|; infinite when `measured` is not finite.
Measurement relative(std::string quantity, double measured, double reference, double bar);
Measurement absolute(std::string quantity, double measured, double reference, double bar,
                     std::string unit = "absolute");

}  // namespace livegs::study
