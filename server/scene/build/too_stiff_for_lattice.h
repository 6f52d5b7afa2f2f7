// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "physics/elastic_body.h"

namespace livegs {

// Ratio of requested to reachable stiffness above which an AUTO object is built as a rigid body. A larger
// value simulates stiff objects as far softer elastic ones.
inline constexpr double kMaxStiffnessRatio = 10.0;

// Returns why the body should be rigid, based on the cells and substeps that would be chosen for it. Returns
// nothing if an elastic body can represent it.
std::optional<std::string> too_stiff_for_lattice(const ElasticBodyDescription& body, double rate_hz,
                                                 int substeps);

}  // namespace livegs
