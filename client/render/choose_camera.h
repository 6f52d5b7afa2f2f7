// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "render/scene_view.h"
#include "splat/frame_bounds.h"

namespace livegs {

// The default camera of a posed view: all objects are in the picture, seen from slightly above. If the
// environment lies to one side (two walls of a room), from the opposite side, so that it is behind the
// objects; else from the front, +z. `free`: the columns of the picture that must contain all objects;
// default: the whole picture.
Camera choose_camera(const SceneView& view, int width, int height,
                     const std::optional<PictureColumns>& free = {});

}  // namespace livegs
