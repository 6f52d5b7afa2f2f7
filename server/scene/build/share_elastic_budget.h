// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>

#include "scene/build/build_object.h"

namespace livegs {

// Sets ElasticBodyDescription::max_node_substeps of each elastic body to its share of the world's budget
// (elastic_budget.h). Precondition: all results are successes.
void share_elastic_budget(std::span<std::optional<Result<BuiltObject>>> built, const WorldSettings& settings);

}  // namespace livegs
