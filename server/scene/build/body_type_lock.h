// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "livegs/v1/physics.pb.h"

namespace livegs {

// What an object was built as when its scene was loaded; it stays that until the scene is loaded anew.
struct BodyTypeLock {
  v1::Physics::Behavior behavior = v1::Physics::RIGID;
  bool can_break = false;  // its kernels can be cut into pieces while it runs
};

// Sets the behaviour of `physics` back to what the object was built as. The result is what of it takes effect
// only when the scene is loaded anew, one line each, for a person; empty when all of it holds at once.
std::vector<std::string> lock_body_type(const BodyTypeLock& built, v1::PhysicalParameters& physics);

}  // namespace livegs
