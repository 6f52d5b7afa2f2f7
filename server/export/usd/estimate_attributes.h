// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "core/result.h"
#include "export/usd/usda_document.h"
#include "export/usd/usda_text.h"
#include "livegs/v1/physics.pb.h"

namespace livegs {

// Writes each field that is set as an attribute livegs:estimate:FIELD, with the field names of physics.proto.
// An EstimatedValue is (low, best, high), with :source and :reason; a list of messages is a list of their
// JSON.
void write_estimates(const v1::PhysicalParameters& estimates, UsdaText& out);
// Reads these attributes; unknown ones are ignored. The error names the attribute.
Result<v1::PhysicalParameters> read_estimates(const UsdaPrim& prim);

}  // namespace livegs
