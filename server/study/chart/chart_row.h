// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "study/harness/setup.h"

namespace livegs::study {

// One run of one scene. Several measurements of a run are several lines of the file.
struct ChartRow {
  std::string scene;    // "tension"
  std::string variant;  // "" on the curves; "table" for what the program chooses by itself
  Setup setup;
  Outcome outcome;
};

// RFC 4180, one header line. The columns up to `bar` are those of every accuracy run of the project.
std::string chart_csv(const std::vector<ChartRow>& rows);

}  // namespace livegs::study
