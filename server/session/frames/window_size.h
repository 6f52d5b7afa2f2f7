// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace livegs {

// How many frames may be under way to one client, by how its acknowledgements ("answers") come. Not locked.
//
// Where nothing is short, ceil(round trip / interval) frames are under way at the full rate, and one more
// lets an answer be late: 2 on a LAN, 4 from 22 ms on. Where a link or a client is slower than the ticks, an
// answer takes long because of the frames before it, and a larger window makes frames older and not more. So
// while answers come at less than the rate, some frames go alone, one at a time: if answers take longer in
// company than alone, a queue stands, and the window becomes the least that keeps four fifths of the pace; if
// not, it grows by one. A size at which a queue stood is tried again after a pause that doubles. (The two
// questions are those of Brakmo and Peterson 1995, TCP Vegas, and Cardwell et al. 2016, BBR.)
class WindowSize {
 public:
  static constexpr size_t kMinFrames = 1, kInitialFrames = 2, kMaxFrames = 4;

  // Of the frames that are offered.
  void set_interval(int64_t interval_ns) { interval_ns_ = interval_ns; }
  size_t frames() const { return lone_left_ > 0 ? 1 : size_; }
  // Whether the link or the client takes frames more slowly than they come, or did a moment ago: with less in
  // them they may fit, and would not if they were whole again. Tried anew after a pause that doubles.
  bool slow(int64_t now_ns) const { return now_ns < slow_until_ns_; }

  struct Answer {
    int64_t written_ns = 0, heard_ns = 0;  // heard_ns never falls
    bool alone = false;                    // nothing else was under way when it was written
    size_t frames = 1;                     // that it answers: its own and those before
  };
  void add(const Answer& answer);

 private:
  void decide(int64_t now_ns);
  void judge(int64_t now_ns);
  void note_slow(int64_t now_ns);
  void forget_answers();

  int64_t interval_ns_ = 11'111'111;
  size_t size_ = kInitialFrames;

  // Since the last decision.
  std::vector<int64_t> round_trips_ns_;
  std::vector<int64_t>
      paces_ns_;          // between answers, of frames that were under way when the one before was answered
  int64_t heard_ns_ = 0;  // the newest answer; 0: none yet
  int64_t decided_ns_ = 0;

  int64_t round_trip_ns_ = 0, pace_ns_ = 0;  // of the last decision
  std::vector<int64_t> lone_;                // round trips of frames that go alone to be measured
  size_t lone_left_ = 0;
  int64_t alone_ns_ = 0, alone_at_ns_ = 0;  // what one takes alone, and when that was measured; 0: never
  size_t queued_at_ = kMaxFrames + 1;       // the least size at which a queue stood
  int64_t queued_until_ns_ = 0, pause_ns_ = 0;
  int64_t slow_until_ns_ = 0, slow_pause_ns_ = 0;
};

}  // namespace livegs
