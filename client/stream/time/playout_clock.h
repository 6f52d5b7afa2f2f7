// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>

namespace livegs {

// Which moment of the simulation a picture shows. Frames come unevenly; the moment shown advances evenly, a
// little behind them, so that nearly every picture lies between two frames that are there. The delay follows
// the network as the playout buffers of speech do (Ramjee et al. 1994, Adaptive playout mechanisms for
// packetized audio applications): it is what 95 of 100 frames of the last two seconds would have needed to be
// there before the moment after the frame before was shown. Moments received and displayed are of one clock,
// the client's. Not locked.
class PlayoutClock {
 public:
  static constexpr int64_t kWindow_ns = 2'000'000'000;
  static constexpr double kOnTimeShare = 0.95;
  // More than the quickest frames need is not waited for; then things go on as they moved (FrameHistory), and
  // then stand.
  static constexpr int64_t kMaxJitter_ns = 100'000'000;
  // The moment shown advances by so much faster or slower at most, while it is behind or ahead of where it
  // should be...
  static constexpr double kMaxRateDeviation = 0.1;
  // ... and jumps when it is off by more than this: after a halt, or when a stream came back.
  static constexpr int64_t kMaxPlayoutError_ns = 200'000'000;
  // After so long without a frame it begins anew: the simulation may have stood meanwhile.
  static constexpr int64_t kSilenceTimeout_ns = 250'000'000;

  // Frames in the order they came. One that is not newer says that the simulation stands.
  void arrived(int64_t simulated_ns, int64_t received_ns);
  // Of a picture that is drawn now and seen at `displayed_ns`; calls in order, after the first arrived().
  // Never goes back, but where it jumps; does not pass a simulation that stands.
  int64_t at(int64_t now_ns, int64_t displayed_ns);
  // Forgets everything, for a simulation that begins again.
  void reset() { *this = PlayoutClock(); }

  // Simulated time that passes in a client's time: 1, or what a server that does not keep up reaches.
  double rate() const;

 private:
  struct Arrival {
    int64_t simulated_ns = 0, received_ns = 0;
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
