// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "core/result.h"
#include "livegs/v1/scene.pb.h"

namespace livegs {

// Checks an object of a scene file without opening its asset. `field` names the object in errors:
// "objects[0]".
Result<void> check_object(const v1::Object& object, const std::string& field);

Result<void> check_box_shape(const v1::BoxShape& box, const std::string& field);
inline constexpr double kMaxSize_m = 1000.0;

// Returns the object's name: the given name, or the stem of its asset or points file.
std::string object_name(const v1::Object& object, int index);

// Prefixes the error with the object's name.
Error of_object(const Error& error, const std::string& name);

}  // namespace livegs
