// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "livegs/v1/physics.pb.h"

namespace livegs {

// Why what is said to be fragile will not break, a line for a person; nothing where it may.
std::optional<std::string> fracture_warning(const v1::PhysicalParameters& physics);

}  // namespace livegs
