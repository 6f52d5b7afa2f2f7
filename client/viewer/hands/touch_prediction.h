// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "core/input_sample.h"
#include "render/scene_view.h"

namespace livegs {

// Whether a hand, or what it holds, comes to touch what is drawn within the next pictures: the hand is a
// ball, the held object its kernels going along with the hand; both go on as they went since the last
// picture. One thread.
class TouchPrediction {
 public:
  struct Touch {
    bool touches = false;
    double speed_m_s = 0;  // of the hand
  };
  // Of what view.pose() was last given, for a picture seen then. `held_id` is what the hand has in its grip,
  // 0: nothing. Nothing for a hand that is not active, or that was not at the last picture.
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
