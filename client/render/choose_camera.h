// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "render/scene_view.h"
#include "splat/camera.h"

namespace livegs {

// The view when nobody says otherwise, for a view that was posed: all objects in the picture, from a little
// above. With an environment that lies to one side (two walls of a room), from the other side, so that it is
// behind the objects; else from in front, +z. `free`: the columns of the picture in which all objects are;
// left out: all of it.
struct PictureColumns {
  double left_px = 0, right_px = 0;
};
Camera choose_camera(const SceneView& view, int width, int height,
                     const std::optional<PictureColumns>& free = {});

}  // namespace livegs
