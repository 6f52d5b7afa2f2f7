// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "study/chart/chart_row.h"
#include "study/chart/chart_scenes.h"

namespace livegs::study {

// The page in Markdown: where each method wins and loses, in words made from the rows; the table of what each
// modulus gets; a picture a scene (NAME.svg beside it). `how` is printed as it was run ("quick" or "full"),
// `version` too.
std::string chart_page(const std::vector<ChartRow>& rows, const std::string& how, const std::string& version);

}  // namespace livegs::study
