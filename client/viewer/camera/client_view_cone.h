// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "core/view_cone.h"
#include "splat/camera.h"

namespace livegs {

// What a server should take as seen: all that these eyes, one or two, show, and what they can turn to in the
// tenth of a second in which the server hears of it and sends the next frame.
ViewCone client_view_cone(std::span<const Camera> eyes);

}  // namespace livegs
