// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "livegs/v1/physics.pb.h"

namespace livegs {

// Returns why an object marked as fragile cannot break, or nothing if it can. One line, for display.
std::optional<std::string> fracture_warning(const v1::PhysicalParameters& physics);

}  // namespace livegs
