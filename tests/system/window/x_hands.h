// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "splat/image.h"

namespace livegs {

// The mouse and the keys of an X display, and an eye, for a test: pointer moves are real, presses are sent to
// one window. Each call has reached that window's program when it returns.
class XHands {
 public:
  // The window of this title on a display as ":7"; null while there is none.
  static std::unique_ptr<XHands> at_window(const std::string& display, const std::string& title);
  ~XHands();

  void move(double x_px, double y_px);  // from the window's top left
  void press(int button = 1);           // 1 the left, 2 the middle, 3 the right; where the pointer is
  void release(int button = 1);
  void key(const std::string& name, bool down);  // X's name of it: "space"
  void close();                                  // as a window manager asks a window to
  Image picture() const;                         // what the window shows; empty until it is on the screen

 private:
  struct Window;
  explicit XHands(std::unique_ptr<Window> window);
  void button(bool down, int which);
  std::unique_ptr<Window> window_;
};

}  // namespace livegs
