// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>

#include "core/result.h"
#include "livegs/v1/scene.pb.h"
#include "physics/world.h"
#include "scene/scene_object.h"

namespace livegs {

// Adds the file's joints to the world that holds its objects. Errors name the joint and the object.
Result<void> add_joints(const v1::Scene& file,
                        const std::function<const SceneObject*(const std::string&)>& find, World& world);

}  // namespace livegs
