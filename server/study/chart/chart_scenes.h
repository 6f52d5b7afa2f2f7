// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "study/harness/setup.h"

namespace livegs::study {

// A scene of the chart and the settings that it is drawn at.
struct ChartScene {
  std::string name;     // "tension"; files are named after it
  std::string title{};  // "Tension: E_app / E"
  std::string what{};   // one sentence for the page: body, load, what is measured
  Result<Outcome> (*run)(const Setup&);
  std::vector<double> youngs_moduli_pa{};  // a panel each
  double poisson_ratio = 0.3;
  std::vector<double> cell_widths_m{};    // the first is the one that variants are shown at
  int max_bullet_substeps = 16;           // 0: Bullet cannot run it
  std::vector<std::string> quantities{};  // measurements that are drawn, a figure each

  // "tension.svg" for the first, "tension_poisson_ratio.svg" for others.
  std::string figure(const std::string& quantity) const;
};

std::span<const ChartScene> chart_scenes();

}  // namespace livegs::study
