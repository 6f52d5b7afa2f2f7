// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/harness/rigid_setup.h"

#include <cstdio>
#include <cstdlib>

namespace livegs::study {

std::string engine_name(RigidEngine engine) {
  switch (engine) {
    case RigidEngine::Livegs:
      return "livegs";
    case RigidEngine::Bullet:
      return "bullet";
    case RigidEngine::OdeQuick:
      return "ode quick";
    case RigidEngine::Ode:
      break;
  }
  return "ode";
}

const char* name_of(RunEnd end) {
  switch (end) {
    case RunEnd::Ok:
      return "ok";
    case RunEnd::Fell:
      return "fell";
    case RunEnd::Exploded:
      return "exploded";
    case RunEnd::NonFinite:
      break;
  }
  return "nan";
}

const Measurement& RigidOutcome::operator[](const std::string& quantity) const {
  for (const Measurement& measurement : measurements) {
    if (measurement.quantity == quantity) return measurement;
  }
  std::fprintf(stderr, "livegs: the scene has no measurement %s\n", quantity.c_str());
  std::abort();
}

}  // namespace livegs::study
