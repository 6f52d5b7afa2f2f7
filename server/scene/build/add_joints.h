// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>

#include "core/result.h"
#include "livegs/v1/scene.pb.h"
#include "scene/scene.h"

namespace livegs {

// What can be said about a joint without opening assets. `find` gives the object of a name, or nullptr; `field` is what errors call
// it: "joints[0]".
Result<void> check_joint(const v1::Joint& joint, const std::function<const v1::Object*(const std::string&)>& find,
                         const std::string& field);

// Puts the file's joints into the world of its objects. Errors name the joint and the object.
Result<void> add_joints(const v1::Scene& file, const std::function<const SceneObject*(const std::string&)>& find,
                        World& world);

// "hinge lid to box" or "ball lamp to the world".
std::string joint_line(const v1::Joint& joint);

}  // namespace livegs
