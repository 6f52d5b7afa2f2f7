// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "livegs/v1/physics.pb.h"

namespace livegs {

// The body type and the parts of an object when its scene was loaded. They stay the same until the scene is
// reloaded.
struct BodyTypeLock {
  v1::Physics::Behavior behavior = v1::Physics::RIGID;
  bool can_break = false;  // its kernels can be cut into pieces at run time
  google::protobuf::RepeatedPtrField<v1::MaterialPart> parts = {};
};

// Sets the behaviour of `physics` back to that of the body. Changed parts stay as decided, so that clients
// can show and edit them. Their reason states that the body changes later. Returns one line, for display, for
// each change that takes effect only after a reload. Returns an empty list if all changes apply at once.
std::vector<std::string> lock_body_type(const BodyTypeLock& built, v1::PhysicalParameters& physics);

}  // namespace livegs
