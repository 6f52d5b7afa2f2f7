// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "physics/elastic_body.h"

namespace livegs {

// A body that is this many times stiffer than any lattice in reach would be simulated as something far softer
// than it is: better not to bend it at all.
inline constexpr double kMaxStiffnessRatio = 10.0;

// Why the body would better be rigid, by the cells and substeps that would be chosen for it; nothing when it
// may well deform.
std::optional<std::string> too_stiff_for_lattice(const ElasticBodyDescription& body, double rate_hz,
                                                 int substeps);

}  // namespace livegs
