// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "render/splat_renderer.h"
#include "stream/received/received.h"
#include "xr/window/window_panels.h"

namespace livegs {

// Timing of a window's pictures, for the graph and the latency line. Times are of now_ns(). One thread.
class FrameMeter {
 public:
  // Records that a sample of the hands was sent.
  void sampled(uint64_t sequence, int64_t sampled_ns);
  // Records a displayed picture of this frame, the time since the last picture, and its pass times.
  void shown(const ReceivedFrame& frame, int64_t shown_ns, double picture_ms,
             const std::optional<DeviceTimes>& device = {});

  FrameGraph graph() const { return graph_; }
  // Pictures displayed and server ticks passed in the last second.
  double pictures_a_second() const;
  double ticks_a_second() const;
  // Latency from the newest hand sample contained in the last picture to that picture; nothing before the
  // first.
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
