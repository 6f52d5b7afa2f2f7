// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "core/result.h"
#include "livegs/v1/physics.pb.h"

namespace livegs {

// Notes `physics` in `as_decided`, so that a later edit by hand is told from what the program wrote.
void seal(v1::PhysicsFile& file);

// Moves what was changed by hand since into `edits` and `name`, and puts the decided values back. A file that
// was never sealed was written by hand: all its values are. True if anything was. Errors begin with the
// field: "physics.mass_kg".
Result<bool> take_manual_edits(v1::PhysicsFile& file);

// What a person edited and the scene's author wrote too, whose words come first: one sentence that names
// these fields and the remedy, empty where there are none.
std::string overridden_edits(const v1::Physics& edits, const v1::Physics& written);

// A name as it is kept: without control characters, at most 80 characters.
std::string physics_name(std::string_view name);

// Edits of one field each way: what was given later wins, also over the field it excludes (mass over
// density).
void merge_edits(v1::Physics& edits, const v1::Physics& later);

}  // namespace livegs
