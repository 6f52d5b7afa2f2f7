// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace livegs {

// Decides when and how strongly a controller vibrates. Each contact is felt once, although the server reports
// it later than it is predicted here. Times are of now_ns(). No I/O; one thread.
class Haptics {
 public:
  struct Pulse {
    float amplitude = 0;  // 0..1
    double seconds = 0;
  };

  // Reports the held object; 0: none. Grabbing produces a pulse. Contact state is reset on a change.
  std::optional<Pulse> holds(size_t hand, uint32_t object_id);

  // Reports whether the hand, or the held object, is predicted to touch something, and the hand's speed. The
  // first call after a change of holds() sets the state without a pulse, since an object taken from a table
  // touches it.
  std::optional<Pulse> foreseen(size_t hand, bool touches, double speed_m_s, int64_t now_ns);

  // Reports the impulse of contacts on the held object in a tick. A contact lasts until a tenth of a second
  // without impulse; within it only an impulse three times as strong produces a new pulse.
  std::optional<Pulse> reported(size_t hand, float impulse_n_s, int64_t now_ns);

  // No prediction is available in this picture; the next one sets the state without a pulse.
  void on_no_prediction(size_t hand) { hands_[hand].touches.reset(); }

 private:
  struct Hand {
    uint32_t held = 0;
    std::optional<bool> touches;
    std::optional<int64_t> predicted_ns, impulse_ns;  // last times
    float contact_impulse_n_s = 0;                    // of the contact reported by the server
  };
  std::array<Hand, 2> hands_;
};

}  // namespace livegs
