// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace livegs {

// When a controller vibrates and how strongly, so that a touch is felt once, whether it is foreseen here or
// told by the server, which comes a network and a simulation later. Moments are of now_ns(). Pure; one
// thread.
class Haptics {
 public:
  struct Pulse {
    float amplitude = 0;  // 0..1
    double seconds = 0;
  };

  // What a hand holds: 0 is nothing. Taking a thing is felt; touching begins anew either way.
  std::optional<Pulse> holds(size_t hand, uint32_t object_id);

  // Whether the hand, or what it holds, is about to touch something as it is drawn, going at this speed. The
  // first word after holds() changed tells how things stand and is not felt: what is taken from a table
  // touches it.
  std::optional<Pulse> foreseen(size_t hand, bool touches, double speed_m_s, int64_t now_ns);

  // What contacts gave the held object in a tick. A touch lasts until there was nothing for a tenth of a
  // second; within it only what is three times as strong as before is felt again.
  std::optional<Pulse> told(size_t hand, float impulse_n_s, int64_t now_ns);

  // Nothing is known of it in this picture: what is said next tells how things stand.
  void on_no_prediction(size_t hand) { hands_[hand].touches.reset(); }

 private:
  struct Hand {
    uint32_t held = 0;
    std::optional<bool> touches;
    std::optional<int64_t> predicted_ns, impulse_ns;  // the last
    float contact_impulse_n_s = 0;                    // of the touch that the server tells of
  };
  std::array<Hand, 2> hands_;
};

}  // namespace livegs
