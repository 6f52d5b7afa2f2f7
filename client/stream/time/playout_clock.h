// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

namespace livegs {

// Maps display time to simulated time. Frames arrive with jitter; the displayed time advances evenly,
// slightly behind them, so that nearly every picture lies between two received frames. The delay adapts to
// the network as in playout buffers for speech (Ramjee et al. 1994, Adaptive playout mechanisms for
// packetized audio applications): it covers the lateness of 95 % of the frames of the last two seconds. Times
// of arrival and display are of the client's clock. Not thread-safe.
class PlayoutClock {
 public:
  static constexpr int64_t kWindow_ns = 2'000'000'000;
  static constexpr double kOnTimeShare = 0.95;
  // Upper bound of the jitter delay. Beyond it, motion is extrapolated and then stops (FrameHistory).
  static constexpr int64_t kMaxJitter_ns = 100'000'000;
  // Maximum relative change of the playback rate during a correction...
  static constexpr double kMaxRateDeviation = 0.1;
  // ... and the error above which the clock jumps, after a halt or a reconnect.
  static constexpr int64_t kMaxPlayoutError_ns = 200'000'000;
  // Silence after which the clock is reset, since the simulation may have been paused.
  static constexpr int64_t kSilenceTimeout_ns = 250'000'000;

  // Frames in order of arrival. A frame that is not newer indicates a paused simulation. `held_until_ns`: the
  // simulated time for which the frame before is valid, if frames were omitted at rest (FrameHistory::add).
  void arrived(int64_t simulated_ns, int64_t received_ns, std::optional<int64_t> held_until_ns = {});
  // Simulated time of a picture that is drawn now and displayed at `displayed_ns`. Call in order, after the
  // first arrived(). Monotonic except for jumps; does not pass the time of a paused simulation.
  int64_t at(int64_t now_ns, int64_t displayed_ns);
  // Discards all state, for a restarted simulation.
  void reset() { *this = PlayoutClock(); }

  // Simulated time per client time: 1, or less if the server does not keep up.
  double rate() const;

 private:
  struct Arrival {
    int64_t simulated_ns = 0, received_ns = 0;
    int64_t held_until_ns = 0;  // the frame before is valid until then
  };
  double wanted_ns(int64_t drawn_ns) const;  // relative to the newest arrival's simulated_ns

  static constexpr size_t kLeadsKept = 64;
  std::deque<Arrival> arrivals_;
  std::deque<int64_t> leads_ns_;  // displayed - now of the last pictures
  int64_t last_drawn_ns_ = 0;
  double shown_ns_ = 0;
  bool shows_ = false;
};

}  // namespace livegs
