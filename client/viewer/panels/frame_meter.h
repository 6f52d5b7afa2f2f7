// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "render/splat_renderer.h"
#include "stream/received/received.h"
#include "xr/window/window_panels.h"

namespace livegs {

// The times of a window's pictures, for its graph and its latency line. Moments are of now_ns(). One thread.
class FrameMeter {
 public:
  // A sample of the hands was sent.
  void sampled(uint64_t sequence, int64_t sampled_ns);
  // A picture of this frame was shown; it took `picture_ms` from the picture before, and its passes so long.
  void shown(const ReceivedFrame& frame, int64_t shown_ns, double picture_ms,
             const std::optional<DeviceTimes>& device = {});

  FrameGraph graph() const { return graph_; }
  // Of the last second of pictures: how many, and how many ticks passed on the server.
  double pictures_a_second() const;
  double ticks_a_second() const;
  // From the newest sample of the hands that is in the last picture to that picture; nothing before there is
  // one.
  std::optional<double> hand_to_picture_ms() const { return hand_to_picture_ms_; }

 private:
  struct Shown {
    int64_t shown_ns = 0;
    uint64_t tick = 0;
  };
  struct Sampled {
    uint64_t sequence = 0;
    int64_t sampled_ns = 0;
  };
  std::deque<Shown> second_;
  std::deque<Sampled> samples_;
  FrameGraph graph_;
  std::optional<double> hand_to_picture_ms_;
};

}  // namespace livegs
