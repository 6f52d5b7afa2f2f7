// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <deque>
#include <map>
#include <set>

namespace livegs {

// Key and button events of a window, collected between pictures so that a press shorter than a picture is not
// lost. Keys and buttons are numbered as by GLFW. One thread.
class WindowEvents {
 public:
  static constexpr int kButtons = 3;  // left, right, middle: the numbers of GLFW
  // Time that a fly key counts as down for a press that is shorter than a picture, seconds: a refresh at
  // 60 Hz. A higher value makes a tap fly further.
  static constexpr double kTap_s = 1.0 / 60;

  // The mouse in one picture.
  struct Mouse {
    Eigen::Vector2d position_px{0, 0};
    std::array<bool, kButtons> down{};     // after the events of this picture
    std::array<bool, kButtons> pressed{};  // went down in this picture
    std::array<bool, kButtons> held{};     // down at any time of this picture
  };

  void on_key(int key, bool down);
  void on_button(int button, bool down, const Eigen::Vector2d& at_px);

  // Begins a picture: the key presses and button events since the last call are its own. A button changes at
  // most once in a picture; its next change is left for the next picture, so a click of any length is down in
  // one picture and up in a later one. In a picture with a change the mouse is where it was then; otherwise
  // at `cursor_px`.
  void begin_picture(const Eigen::Vector2d& cursor_px);

  const Mouse& mouse() const { return mouse_; }
  int presses(int key) const;  // in this picture, repeats excluded
  bool toggled(int key) const { return presses(key) % 2 == 1; }
  // Share of a picture of `passed_s` seconds for which a key was down, 0..1. Events have no times: a key that
  // is down counts for the whole picture, a press and release for kTap_s.
  double held_share(int key, double passed_s) const;
  // Keys that are down or were pressed in this picture.
  bool held(int key) const { return down_.contains(key) || presses(key) > 0; }
  // Keys with an event since the beginning.
  const std::set<int>& used_keys() const { return used_; }
  // Whether events wait for the next picture.
  bool waiting() const { return !buttons_.empty() || !coming_.empty(); }

 private:
  struct ButtonEvent {
    int button = 0;
    bool down = false;
    Eigen::Vector2d at_px{0, 0};
  };
  std::deque<ButtonEvent> buttons_;
  std::map<int, int> coming_, presses_;  // by key: since begin_picture(), and before
  std::set<int> down_, used_;
  Mouse mouse_;
};

}  // namespace livegs
