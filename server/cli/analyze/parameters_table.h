// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "livegs/v1/physics.pb.h"

namespace livegs {

// All values of one object with ranges and reasons, or one table row per object. Each line ends in a newline.
std::string parameters_text(const v1::PhysicalParameters& parameters);
std::string table_head();
std::string table_row(const std::string& name, const v1::PhysicalParameters& parameters);

}  // namespace livegs
