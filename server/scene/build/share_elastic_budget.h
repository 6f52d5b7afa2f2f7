// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>

#include "scene/build/build_object.h"

namespace livegs {

// Gives each elastic body its part of the world's budget (elastic_budget.h):
// ElasticBodyDescription::max_node_substeps. All results are successes.
void share_elastic_budget(std::span<std::optional<Result<BuiltObject>>> built, const WorldSettings& settings);

}  // namespace livegs
