// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "livegs/v1/physics.pb.h"

namespace livegs {

// Print to standard output: all values of one object with ranges and reasons, or one table row per object.
void print_parameters(const v1::PhysicalParameters& parameters);
void print_table_head();
void print_table_row(const std::string& name, const v1::PhysicalParameters& parameters);

}  // namespace livegs
