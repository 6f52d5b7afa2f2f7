// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "livegs/v1/session.pb.h"
#include "scene/scene.h"
#include "session/asset_store.h"

namespace livegs {

// What a client is told of an object: RestBody encoded, asset named by its hash.
v1::ObjectDescription describe_object(const SceneObject& object, const AssetBytes& asset);

}  // namespace livegs
