// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "core/result.h"
#include "livegs/v1/physics.pb.h"

namespace livegs {

// Stores a copy of `physics` in `as_decided`, so that later manual edits of the file can be detected.
void seal(v1::PhysicsFile& file);

// Moves manual changes into `edits` and `name`, and restores the decided values. In a file that was never
// sealed, all values are manual. Returns true if anything changed. Errors begin with the field:
// "physics.mass_kg".
Result<bool> take_manual_edits(v1::PhysicsFile& file);

// Lists edits that the scene's author overrides: one sentence with the fields and the remedy, or "".
std::string overridden_edits(const v1::Physics& edits, const v1::Physics& written);

// Sanitised name: without control characters, at most 80 characters.
std::string physics_name(std::string_view name);

// Merges edits by field: the later value wins, also over a mutually exclusive field (mass over density).
void merge_edits(v1::Physics& edits, const v1::Physics& later);
// Removes fields of Physics. InvalidArgument for another name; NotFound if none of them is edited.
Result<void> remove_edits(v1::Physics& edits, std::span<const std::string> fields);

}  // namespace livegs
