// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "livegs/v1/scene.pb.h"

namespace livegs {

// Changes the name of an object in events and joints.
void rename_references(v1::Scene& scene, const std::string& from, const std::string& to);
// The event or joint that names the object, such as "events[2]"; empty if there is none.
std::string reference_to(const v1::Scene& scene, const std::string& name);

}  // namespace livegs
