// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include "analysis/text/message_templates.h"
#include "core/result.h"

namespace livegs {

// Converts a value to another unit of the same quantity: length, area, volume, mass, density, pressure or
// force. Accepts common spellings: mm, in, cm3, l, oz, lb, g/cm3, psi. The error names the unit that is
// unknown or does not fit.
Result<double> convert_unit(double value, std::string_view from, std::string_view to,
                            const MessageTemplates& words = MessageTemplates::built_in());

}  // namespace livegs
