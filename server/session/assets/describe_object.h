// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "livegs/v1/session.pb.h"
#include "scene/scene.h"
#include "session/assets/asset_store.h"

namespace livegs {

// What a client is told of an object: RestBody encoded, asset named by its hash. Encodes its asset if
// `assets` does not have it yet; the one it breaks into is named if it has.
v1::ObjectDescription describe_object(const SceneObject& object, AssetStore& assets);

}  // namespace livegs
