// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "core/view_cone.h"
#include "splat/camera.h"

namespace livegs {

// The region the server should treat as visible: everything these one or two eyes show, plus the motion
// within the tenth of a second until the next frame for the new view arrives.
ViewCone client_view_cone(std::span<const Camera> eyes);

}  // namespace livegs
