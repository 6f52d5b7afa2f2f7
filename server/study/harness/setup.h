// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "physics/elastic_body.h"

// Setup and outcome of a canonical elastic scene. Scenes are numbered as in the project's test catalogue: 8
// pendulum, 20 tension, 21 cantilever, 22 torsion, 23 ring-down, 24 squash, 27 plastic set.

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
  int substeps = 4;             // per frame of the scene
  double cell_width_m = 0.025;  // 0: chosen by the body
  double spacing_m = 0.025;     // particle spacing; the finest resolution of livegs-v1
  double youngs_modulus_pa = 1e5;
  double poisson_ratio = 0.3;
  double density_kg_m3 = 1000.0;
};

// Name of a curve of the chart: "cells", "cells BDF1", "cells uncompensated", "cells BDF1 uncompensated",
// "cells chosen", "livegs-v1", "livegs-v1 steady", "bullet".
std::string solver_name(const Setup& setup);

// Processor time of substeps and ends of frames only.
struct Cost {
  double cpu_s = 0.0;
  double wall_s = 0.0;  // of the whole scene, including measurements
  double simulated_s = 0.0;
  uint64_t substeps = 0;  // of the body
  uint64_t frames = 0;

  double cpu_ns_per_simulated_s() const { return simulated_s > 0.0 ? 1e9 * cpu_s / simulated_s : 0.0; }
};

// One figure of a scene and its reference.
struct Measurement {
  std::string quantity;  // "youngs_modulus", "poisson_ratio", "deflection", …
  double measured = 0.0, reference = 0.0;
  double error = 0.0;  // not negative; relative unless the unit differs
  std::string unit;    // of `error`: "relative", "absolute" (dimensionless), "m", "m/s", …
  double bar = 0.0;    // limit of `error` where the program calls the setting valid
};

struct Outcome {
  std::vector<Measurement> measurements;  // the first is drawn in the chart
  Cost cost;
  ElasticAccuracy accuracy;
  bool finite = true;  // all final particle positions are finite; otherwise the errors are infinite

  const Measurement& operator[](const std::string& quantity) const;  // precondition: it exists
};

// |measured / reference - 1| or |measured - reference|; infinite if `measured` is not finite.
Measurement relative(std::string quantity, double measured, double reference, double bar);
Measurement absolute(std::string quantity, double measured, double reference, double bar,
                     std::string unit = "absolute");

}  // namespace livegs::study
