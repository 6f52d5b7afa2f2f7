// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/harness/setup.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>

namespace livegs::study {
namespace {

double finite_or_infinity(double error) {
  return std::isfinite(error) ? error : std::numeric_limits<double>::infinity();
}

}  // namespace

std::string solver_name(const Setup& setup) {
  switch (setup.engine) {
    case Engine::LivegsV1:
      return "livegs-v1";
    case Engine::LivegsV1Steady:
      return "livegs-v1 steady";
    case Engine::Bullet:
      return "bullet";
    case Engine::Cells:
      break;
  }
  if (setup.cells.choose) return "cells chosen";
  std::string name = "cells";
  if (!setup.cells.second_order) name += " BDF1";
  if (!setup.cells.compensate) name += " uncompensated";
  return name;
}

const Measurement& Outcome::operator[](const std::string& quantity) const {
  for (const Measurement& measurement : measurements) {
    if (measurement.quantity == quantity) return measurement;
  }
  std::fprintf(stderr, "livegs: the scene has no measurement %s\n", quantity.c_str());
  std::abort();
}

Measurement relative(std::string quantity, double measured, double reference, double bar) {
  return {std::move(quantity), measured, reference, finite_or_infinity(std::abs(measured / reference - 1.0)),
          "relative",          bar};
}

Measurement absolute(std::string quantity, double measured, double reference, double bar, std::string unit) {
  return {std::move(quantity), measured, reference, finite_or_infinity(std::abs(measured - reference)),
          std::move(unit),     bar};
}

}  // namespace livegs::study
