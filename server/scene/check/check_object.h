// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "core/result.h"
#include "livegs/v1/scene.pb.h"

namespace livegs {

// What can be said about an object of a scene without opening its asset. `field` is what errors call it:
// "objects[0]".
Result<void> check_object(const v1::Object& object, const std::string& field);

Result<void> check_box_shape(const v1::BoxShape& box, const std::string& field);
inline constexpr double kMaxSize_m = 1000.0;

// The name an object goes by: its own, or the stem of its asset's or points' file.
std::string object_name(const v1::Object& object, int index);

// The error with the object's name before it, so that a person finds it in a scene of many.
Error of_object(const Error& error, const std::string& name);

}  // namespace livegs
