// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>

#include "core/input_sample.h"
#include "core/result.h"
#include "render/scene_view.h"
#include "stream/received/received.h"

namespace livegs {

// Markers of the hands in a headset: a ball, a ray, and a row of beads along the force from the held point.
// They are kernels and are sorted with the scene.
class HandMarkers {
 public:
  // Call once. Uses the two highest ids; servers count from 1.
  static Result<void> add_to(SceneView& view);
  static bool is_marker(uint32_t object_id);

  // A force exerted by a hand.
  struct Force {
    size_t hand = 0;
    Eigen::Vector3d point_m, arrow_m;  // point of application, and vector from there to the tip
  };
  // Adds the active hands to the drivers of a picture.
  static void append(const std::array<HandSample, 2>& hands, std::span<const Force> forces,
                     DriverFrame& drivers);
};

}  // namespace livegs
