// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "study/harness/setup.h"

namespace livegs::study {

// A scene of the chart and its settings.
struct ChartScene {
  std::string name;     // "tension"; also the file name
  std::string title{};  // "Tension: E_app / E"
  std::string what{};   // for the page: body, load and figures
  Result<Outcome> (*run)(const Setup&);
  std::vector<double> youngs_moduli_pa{};  // one panel each
  double poisson_ratio = 0.3;
  std::vector<double> cell_widths_m{};    // variants are run at the first width
  int max_bullet_substeps = 16;           // 0: not supported by Bullet
  std::vector<std::string> quantities{};  // drawn measurements, one figure each

  // "tension.svg" for the first, "tension_poisson_ratio.svg" for others.
  std::string figure(const std::string& quantity) const;
};

std::span<const ChartScene> chart_scenes();

}  // namespace livegs::study
