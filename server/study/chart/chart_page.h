// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "study/chart/chart_row.h"
#include "study/chart/chart_scenes.h"

namespace livegs::study {

// Writes the page in Markdown: a comparison of the methods generated from the rows, the table by modulus, and
// one figure per scene (NAME.svg next to it). `how` is the kind of run ("quick" or "full"); it is printed, as
// is `version`.
std::string chart_page(const std::vector<ChartRow>& rows, const std::string& how, const std::string& version);

}  // namespace livegs::study
