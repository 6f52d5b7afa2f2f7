// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "core/input_sample.h"
#include "render/scene_view.h"

namespace livegs {

// Predicts whether a hand, or its held object, touches the drawn scene within the next pictures. The hand is
// a sphere; the held object's kernels move with the hand. Velocities are extrapolated from the last picture.
// One thread.
class TouchPrediction {
 public:
  struct Touch {
    bool touches = false;
    double speed_m_s = 0;  // of the hand
  };
  // For the last pose of the view and a picture displayed at `displayed_ns`. `held_id`: the grabbed object,
  // 0: none. Nothing for a hand that is inactive or was missing in the last picture.
  std::optional<Touch> at(size_t hand, const HandSample& sample, uint32_t held_id, const SceneView& view,
                          int64_t displayed_ns);

 private:
  struct Last {
    Eigen::Vector3d place_m;
    int64_t displayed_ns = 0;
    bool touches = false;
  };
  std::array<std::optional<Last>, 2> last_;
};

}  // namespace livegs
