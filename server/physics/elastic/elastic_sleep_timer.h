// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "physics/motion/lasting_time.h"

namespace livegs {

// Sleep state of an elastic body (rigid bodies: physics/rigid/rigid_sleep.h): it may sleep after being still
// for kLastingTime_s.
class SleepTimer {
 public:
  explicit SleepTimer(bool may_sleep) : may_sleep_(may_sleep) {}

  // Call once per tick. Returns true if the body falls asleep now. Unsupported bodies and bodies under a
  // force are not still. A deferred body only becomes able to sleep.
  bool tick(double frame_s, bool still) {
    if (!may_sleep_ || asleep_) return false;
    still_s_ = still ? still_s_ + frame_s : 0.0;
    asleep_ = can_sleep() && !deferred_;
    return asleep_;
  }
  void defer(bool deferred) { deferred_ = deferred; }
  bool can_sleep() const { return asleep_ || (may_sleep_ && still_s_ >= kLastingTime_s - 1e-9); }
  void sleep() { asleep_ = true; }
  void wake() {
    asleep_ = false;
    still_s_ = 0.0;
  }
  bool asleep() const { return asleep_; }

 private:
  bool may_sleep_;
  bool asleep_ = false, deferred_ = false;
  double still_s_ = 0.0;
};

}  // namespace livegs
