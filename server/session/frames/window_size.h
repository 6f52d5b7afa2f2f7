// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace livegs {

// The number of frames in flight to one client, derived from its acknowledgements ("answers"). Not locked.
//
// Without congestion, ceil(round trip / interval) frames in flight sustain the full rate, and one more
// absorbs a late acknowledgement. If the link or the client is slower than the tick rate, a larger window
// only adds latency.
//
// To distinguish these cases while acknowledgements arrive below the full rate, some frames are sent alone.
// If their round trips are shorter than the usual ones, a queue exists: the window shrinks to the smallest
// size that keeps 4/5 of the rate. Otherwise it grows by one. A size with a queue is tried again after a
// pause that doubles.
//
// Compare Brakmo and Peterson 1995, TCP Vegas, and Cardwell et al. 2016, BBR.
class WindowSize {
 public:
  static constexpr size_t kMinFrames = 1, kInitialFrames = 2, kMaxFrames = 4;

  // Interval of the offered frames.
  void set_interval(int64_t interval_ns) { interval_ns_ = interval_ns; }
  size_t frames() const { return lone_left_ > 0 ? 1 : size_; }
  // True if the link or the client is, or recently was, slower than the frame rate. Smaller frames may fit;
  // full frames are tried again after a pause that doubles.
  bool slow(int64_t now_ns) const { return now_ns < slow_until_ns_; }

  struct Answer {
    int64_t written_ns = 0, received_ns = 0;  // received_ns must not decrease
    bool alone = false;                       // no other frame was in flight when it was written
    size_t frames = 1;                        // number of frames acknowledged, including earlier ones
  };
  void add(const Answer& answer);

 private:
  void decide(int64_t now_ns);
  void judge(int64_t now_ns);
  void note_slow(int64_t now_ns);
  void clear_answers();

  int64_t interval_ns_ = 11'111'111;
  size_t size_ = kInitialFrames;

  // Since the last decision.
  std::vector<int64_t> round_trips_ns_;
  std::vector<int64_t> paces_ns_;  // acknowledgement intervals of back-to-back frames
  int64_t last_answer_ns_ = 0;     // the newest answer; 0: none
  int64_t decided_ns_ = 0;

  int64_t round_trip_ns_ = 0, pace_ns_ = 0;  // at the last decision
  std::vector<int64_t> lone_;                // round trips of lone frames
  size_t lone_left_ = 0;
  int64_t alone_ns_ = 0, alone_at_ns_ = 0;  // median lone round trip and its time; 0: never measured
  size_t queued_at_ = kMaxFrames + 1;       // smallest window at which a queue existed
  int64_t queued_until_ns_ = 0, pause_ns_ = 0;
  int64_t slow_until_ns_ = 0, slow_pause_ns_ = 0;
};

}  // namespace livegs
