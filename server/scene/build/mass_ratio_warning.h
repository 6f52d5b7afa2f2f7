// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>

#include "scene/build/build_object.h"

namespace livegs {

// Adds a warning to each rigid object that is so much heavier than the lightest rigid object of the scene
// that it would sink into it at the substeps of `settings`. Precondition: all results are successes.
void warn_of_mass_ratios(std::span<std::optional<Result<BuiltObject>>> built, const WorldSettings& settings);

}  // namespace livegs
