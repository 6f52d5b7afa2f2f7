// SPDX-License-Identifier: Apache-2.0
#include "xr/window/window_events.h"

#include <algorithm>
#include <utility>

namespace livegs {

void WindowEvents::on_key(int key, bool down) {
  used_.insert(key);
  if (!down) {
    down_.erase(key);
  } else if (down_.insert(key).second) {
    ++coming_[key];
  }
}

void WindowEvents::on_button(int button, bool down, const Eigen::Vector2d& at_px) {
  if (button >= 0 && button < kButtons) buttons_.push_back({button, down, at_px});
}

void WindowEvents::begin_picture(const Eigen::Vector2d& cursor_px) {
  presses_ = std::exchange(coming_, {});
  mouse_.position_px = cursor_px;
  mouse_.pressed = {};
  mouse_.held = mouse_.down;
  std::array<bool, kButtons> changed{};
  while (!buttons_.empty() && !changed[buttons_.front().button]) {
    const ButtonEvent event = buttons_.front();
    buttons_.pop_front();
    if (mouse_.down[event.button] == event.down) continue;
    changed[event.button] = true;
    mouse_.position_px = event.at_px;
    mouse_.down[event.button] = event.down;
    mouse_.pressed[event.button] = event.down;
    mouse_.held[event.button] = true;
  }
}

int WindowEvents::presses(int key) const {
  const auto found = presses_.find(key);
  return found == presses_.end() ? 0 : found->second;
}

double WindowEvents::held_share(int key, double passed_s) const {
  if (down_.contains(key)) return 1;
  const int taps = presses(key);
  return taps == 0 ? 0 : std::min(1.0, taps * kTap_s / std::max(passed_s, kTap_s));
}

}  // namespace livegs
