// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>

#include "core/result.h"
#include "livegs/v1/scene.pb.h"
#include "scene/values/scene_values.h"

namespace livegs {

// A joint of a scene file, of either kind. Refers to the joint.
struct JointParts {
  std::string kind, object, other;
  const Numbers* point_m = nullptr;
  const Numbers* axis = nullptr;  // of a hinge
};

// Precondition: the joint has a kind.
JointParts parts_of(const v1::Joint& joint);

// What can be said about a joint without opening assets. `find` gives the object of a name, or nullptr;
// `field` is what errors call it: "joints[0]".
Result<void> check_joint(const v1::Joint& joint,
                         const std::function<const v1::Object*(const std::string&)>& find,
                         const std::string& field);

// "hinge lid to box" or "ball lamp to the world".
std::string joint_line(const v1::Joint& joint);

}  // namespace livegs
