// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>

#include "core/result.h"
#include "livegs/v1/scene.pb.h"
#include "scene/values/scene_values.h"

namespace livegs {

// Common view of a ball or hinge joint of a scene file. Holds pointers into the joint.
struct JointParts {
  std::string kind, object, other;
  const Numbers* point_m = nullptr;
  const Numbers* axis = nullptr;  // hinges only; else null
};

// Precondition: the joint has a kind.
JointParts parts_of(const v1::Joint& joint);

// Checks a joint without opening assets. `find` returns the object with a name, or nullptr. `field` names the
// joint in errors: "joints[0]".
Result<void> check_joint(const v1::Joint& joint,
                         const std::function<const v1::Object*(const std::string&)>& find,
                         const std::string& field);

// Formats a joint as "hinge lid to box" or "ball lamp to the world".
std::string joint_line(const v1::Joint& joint);

}  // namespace livegs
