// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "study/harness/setup.h"

namespace livegs::study {

// One run of one scene. Each measurement of a run is a line of the file.
struct ChartRow {
  std::string scene;    // "tension"
  std::string variant;  // "" on the curves; "table" for values chosen by the program
  Setup setup;
  Outcome outcome;
};

// CSV (RFC 4180) with one header line. The columns up to `bar` are common to all accuracy runs of the
// project.
std::string chart_csv(const std::vector<ChartRow>& rows);

}  // namespace livegs::study
