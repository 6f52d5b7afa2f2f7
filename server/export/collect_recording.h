// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "core/result.h"
#include "export/portable_scene.h"

namespace livegs {

// Adds the motion in a recording (*.lvgrec) to the scene that was recorded. Objects are matched by name.
// - Rigid bodies get a pose per frame, elastic ones the positions of their lattice nodes.
// - Balls, added objects and fragments become separate bodies that are only drawn. They exist from their
//   first frame to their last. Their assets are taken from the recording.
// Fails if the recording has no frames, an asset is missing, or an object does not match the scene.
Result<void> collect_recording(const std::filesystem::path& path, PortableScene& scene);

}  // namespace livegs
