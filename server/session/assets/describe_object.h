// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "livegs/v1/session.pb.h"
#include "scene/scene.h"
#include "session/assets/asset_store.h"

namespace livegs {

// The description of an object for clients: its encoded RestBody and the hash of its asset. Encodes the asset
// if `assets` does not contain it. The asset of its fragments is included only if it is already encoded.
v1::ObjectDescription describe_object(const SceneObject& object, AssetStore& assets);

}  // namespace livegs
