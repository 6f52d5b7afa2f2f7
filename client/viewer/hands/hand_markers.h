// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>

#include "core/input_sample.h"
#include "core/result.h"
#include "render/scene_view.h"
#include "stream/received/received.h"

namespace livegs {

// What is seen of the hands in a headset: a ball where each is, its ray, and a row of beads from the point it
// holds along the force there. They are kernels as all else, sorted with the scene.
class HandMarkers {
 public:
  // Once. Their ids are the last two there are; a server counts from 1.
  static Result<void> add_to(SceneView& view);
  static bool is_marker(uint32_t object_id);

  // A force that a hand exerts.
  struct Force {
    size_t hand = 0;
    Eigen::Vector3d point_m, arrow_m;  // from there to its tip
  };
  // Adds the hands that are active to what a picture shows.
  static void append(const std::array<HandSample, 2>& hands, std::span<const Force> forces,
                     DriverFrame& drivers);
};

}  // namespace livegs
