// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "livegs/v1/scene.pb.h"
#include "physics/world.h"
#include "scene/scene_object.h"

namespace livegs {

// Sets SceneObject::mass_ratio_warning of all objects: of each rigid object of the file that would sink into
// the lightest one that it can rest on, at the substeps of `settings`. Objects joined by one of `joints` do
// not collide, and nothing rests without gravity. Returns the ids of the objects whose warning changed.
std::vector<uint32_t> update_mass_ratio_warnings(std::deque<SceneObject>& objects,
                                                 const google::protobuf::RepeatedPtrField<v1::Joint>& joints,
                                                 const WorldSettings& settings);

}  // namespace livegs
