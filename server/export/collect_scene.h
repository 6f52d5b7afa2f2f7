// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "core/result.h"
#include "export/portable_scene.h"

namespace livegs {

// Builds a scene file or a folder of assets, as a run does, and collects its bodies in the state before the
// first tick. Errors are those of Scene::load. Blocks until all bodies are built.
//
// Contact surfaces: exact for shapes; the collision mesh of a rigid capture. Captured elastic and static
// bodies collide by particles and by a distance field; their surface is computed again from the same points.
// A captured background that collides has a distance field only; a note names it.
// Inertia of an elastic body: of its particles at rest, each a cube of its volume.
Result<PortableScene> collect_scene(const std::filesystem::path& path);

}  // namespace livegs
