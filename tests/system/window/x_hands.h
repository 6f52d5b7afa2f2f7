// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "splat/image.h"

namespace livegs {

// Mouse, keyboard and screenshots on an X display for a test. Pointer moves are real; presses are sent to one
// window. When a call returns, the program of that window has received its events.
class XHands {
 public:
  // The window with this title on a display such as ":7"; null if there is none.
  static std::unique_ptr<XHands> at_window(const std::string& display, const std::string& title);
  ~XHands();

  void move(double x_px, double y_px);  // relative to the window's top left
  void press(int button = 1);           // 1 left, 2 middle, 3 right; at the pointer position
  void release(int button = 1);
  void key(const std::string& name, bool down);  // X key name: "space"
  void place(int x_px, int y_px);                // the window's top left on the screen
  void close();                                  // as a window manager requests it
  // Drops files at a place, as a file manager does (XDND). Blocks until the window has taken them, so it is
  // called on a thread of its own; false if the window does not take them within ten seconds.
  bool drop_files(const std::vector<std::string>& files, double x_px, double y_px) const;
  Image picture() const;  // content of the window; empty until it is mapped

 private:
  struct Window;
  explicit XHands(std::unique_ptr<Window> window);
  void button(bool down, int which);
  std::unique_ptr<Window> window_;
};

}  // namespace livegs
