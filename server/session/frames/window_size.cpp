// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/frames/window_size.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace livegs {
namespace {

// Acknowledgements per decision; the minimum if kMaxDecisionInterval_ns has passed. A stall delays at most
// four of them, so it does not dominate the statistics.
constexpr size_t kAnswersPerDecision = 32, kMinAnswers = 8;
constexpr int64_t kMaxDecisionInterval_ns = 2'000'000'000;
// Acknowledgements that decide whether a size that was too large is still too large.
constexpr size_t kTrialAnswerCount = 12;
constexpr size_t kLoneFrameCount = 5;
constexpr int64_t kLoneMeasurementLifetime_ns = 10'000'000'000;
constexpr int64_t kMinPause_ns = 10'000'000'000, kMaxPause_ns = 40'000'000'000;
// Acknowledgements count as slow if their interval exceeds the tick interval by this ratio. A queue exists if
// round trips exceed those of lone frames by the second ratio. Both are above the noise.
constexpr double kSlowdownRatio = 1.1, kQueueRatio = 1.25;
// Fraction of a frame by which the window may fall short of filling the link; the rate stays above 4/5.
constexpr double kMaxPipeGap = 0.25;
// Hysteresis, in tick intervals: a round trip must fall this far below the growth limit before the window
// shrinks.
constexpr double kHysteresis = 0.25;

int64_t median(std::vector<int64_t>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Mean without the longest eighth, which excludes stalls.
int64_t usual_mean(std::vector<int64_t>& values) {
  std::sort(values.begin(), values.end());
  const auto end = values.end() - static_cast<std::ptrdiff_t>(values.size() / 8);
  return std::accumulate(values.begin(), end, int64_t{0}) / (end - values.begin());
}

double ratio(int64_t a, int64_t b) {
  return static_cast<double>(a) / static_cast<double>(std::max<int64_t>(b, 1));
}

size_t window_of(double intervals) {
  return static_cast<size_t>(
      std::clamp(std::ceil(intervals), double{WindowSize::kMinFrames}, double{WindowSize::kMaxFrames}));
}

}  // namespace

void WindowSize::add(const Answer& answer) {
  const int64_t round_trip_ns = answer.received_ns - answer.written_ns;
  const int64_t before_ns = last_answer_ns_;
  last_answer_ns_ = answer.received_ns;
  if (decided_ns_ == 0) decided_ns_ = answer.received_ns;
  if (lone_left_ > 0) {
    if (!answer.alone) return;
    lone_.push_back(round_trip_ns);
    if (--lone_left_ > 0) return;
    alone_ns_ = median(lone_);
    alone_at_ns_ = last_answer_ns_;
    judge(last_answer_ns_);
    clear_answers();
    return;
  }
  round_trips_ns_.push_back(round_trip_ns);
  if (answer.written_ns < before_ns)
    paces_ns_.push_back((last_answer_ns_ - before_ns) /
                        static_cast<int64_t>(std::max<size_t>(answer.frames, 1)));
  const size_t enough = size_ >= queued_at_ ? kTrialAnswerCount : kAnswersPerDecision;
  const bool few =
      round_trips_ns_.size() >= kMinAnswers && last_answer_ns_ - decided_ns_ >= kMaxDecisionInterval_ns;
  if (round_trips_ns_.size() < enough && !few) return;
  decide(last_answer_ns_);
  clear_answers();
}

void WindowSize::clear_answers() {
  round_trips_ns_.clear();
  paces_ns_.clear();
  decided_ns_ = last_answer_ns_;
}

void WindowSize::decide(int64_t now_ns) {
  round_trip_ns_ = median(round_trips_ns_);
  const bool paced = paces_ns_.size() >= kMinAnswers / 2;
  pace_ns_ = paced ? usual_mean(paces_ns_) : 0;
  const bool slower =
      size_ == 1 ? round_trip_ns_ > interval_ns_ : ratio(pace_ns_, interval_ns_) > kSlowdownRatio;
  if (!slower) {
    const double intervals = ratio(round_trip_ns_, interval_ns_);
    const size_t grown = window_of(std::ceil(intervals) + 1),
                 shrunk = window_of(std::ceil(intervals + kHysteresis) + 1);
    if (grown > size_) size_ = grown;
    if (shrunk < size_) size_ = shrunk;
    queued_at_ = kMaxFrames + 1;
    pause_ns_ = 0;
    return;
  }
  if (size_ == 1) {
    note_slow(now_ns);
    alone_ns_ = round_trip_ns_;
    alone_at_ns_ = now_ns;
  }
  if (alone_ns_ == 0 || now_ns - alone_at_ns_ > kLoneMeasurementLifetime_ns) {
    lone_.clear();
    lone_left_ = kLoneFrameCount;
    return;
  }
  judge(now_ns);
}

void WindowSize::note_slow(int64_t now_ns) {
  if (!slow(now_ns)) {
    const bool again = slow_pause_ns_ > 0 && now_ns < slow_until_ns_ + slow_pause_ns_;
    slow_pause_ns_ = again ? std::min(2 * slow_pause_ns_, kMaxPause_ns) : kMinPause_ns;
  }
  slow_until_ns_ = now_ns + slow_pause_ns_;
}

void WindowSize::judge(int64_t now_ns) {
  if (size_ > 1 && ratio(round_trip_ns_, alone_ns_) > kQueueRatio) {
    note_slow(now_ns);
    size_ = std::min(size_ - 1, window_of(ratio(alone_ns_, pace_ns_) - kMaxPipeGap));
    queued_at_ = size_ + 1;
    pause_ns_ = pause_ns_ == 0 ? kMinPause_ns : std::min(2 * pause_ns_, kMaxPause_ns);
    queued_until_ns_ = now_ns + pause_ns_;
    return;
  }
  if (size_ >= queued_at_) {  // the queue is gone
    queued_at_ = kMaxFrames + 1;
    pause_ns_ = 0;
  }
  // either slow with a queue hidden by the latency, or too far away for four frames
  if (size_ == kMaxFrames) note_slow(now_ns);
  if (size_ < kMaxFrames && (size_ + 1 < queued_at_ || now_ns >= queued_until_ns_)) ++size_;
}

}  // namespace livegs
