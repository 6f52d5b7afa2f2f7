// SPDX-License-Identifier: Apache-2.0
#include "system/window/x_hands.h"

#include <X11/Xlib.h>
#include <X11/Xutil.h>

#include <cmath>

namespace livegs {

struct XHands::Window {
  Display* display = nullptr;
  ::Window window = 0;
  int x_px = 0, y_px = 0;
};

namespace {

::Window find(Display* display, ::Window under, const std::string& title) {
  char* name = nullptr;
  if (XFetchName(display, under, &name) && name) {
    const bool is_it = title == name;
    XFree(name);
    if (is_it) return under;
  }
  ::Window root = 0, parent = 0, *children = nullptr, found = 0;
  unsigned count = 0;
  if (!XQueryTree(display, under, &root, &parent, &children, &count)) return 0;
  for (unsigned i = 0; i < count && !found; ++i) found = find(display, children[i], title);
  if (children) XFree(children);
  return found;
}

}  // namespace

XHands::XHands(std::unique_ptr<Window> window) : window_(std::move(window)) {}

XHands::~XHands() { XCloseDisplay(window_->display); }

std::unique_ptr<XHands> XHands::at_window(const std::string& display, const std::string& title) {
  Display* opened = XOpenDisplay(display.c_str());
  if (!opened) return nullptr;
  const ::Window window = find(opened, DefaultRootWindow(opened), title);
  if (!window) {
    XCloseDisplay(opened);
    return nullptr;
  }
  return std::unique_ptr<XHands>(new XHands(std::make_unique<Window>(Window{opened, window})));
}

void XHands::move(double x_px, double y_px) {
  window_->x_px = static_cast<int>(std::lround(x_px));
  window_->y_px = static_cast<int>(std::lround(y_px));
  XWarpPointer(window_->display, None, window_->window, 0, 0, 0, 0, window_->x_px, window_->y_px);
  XSync(window_->display, False);
}

void XHands::button(bool down, int which) {
  XEvent event{};
  event.type = down ? ButtonPress : ButtonRelease;
  event.xbutton.window = window_->window;
  event.xbutton.root = DefaultRootWindow(window_->display);
  event.xbutton.x = event.xbutton.x_root = window_->x_px;
  event.xbutton.y = event.xbutton.y_root = window_->y_px;
  event.xbutton.state = down ? 0 : Button1Mask << (which - 1);
  event.xbutton.button = static_cast<unsigned>(which);
  event.xbutton.same_screen = True;
  XSendEvent(window_->display, window_->window, False, down ? ButtonPressMask : ButtonReleaseMask, &event);
  XSync(window_->display, False);
}

void XHands::press(int which) { button(true, which); }
void XHands::release(int which) { button(false, which); }

void XHands::key(const std::string& name, bool down) {
  XEvent event{};
  event.type = down ? KeyPress : KeyRelease;
  event.xkey.window = window_->window;
  event.xkey.root = DefaultRootWindow(window_->display);
  event.xkey.keycode = XKeysymToKeycode(window_->display, XStringToKeysym(name.c_str()));
  event.xkey.same_screen = True;
  XSendEvent(window_->display, window_->window, False, down ? KeyPressMask : KeyReleaseMask, &event);
  XSync(window_->display, False);
}

void XHands::close() {
  XEvent event{};
  event.type = ClientMessage;
  event.xclient.window = window_->window;
  event.xclient.message_type = XInternAtom(window_->display, "WM_PROTOCOLS", False);
  event.xclient.format = 32;
  event.xclient.data.l[0] = static_cast<long>(XInternAtom(window_->display, "WM_DELETE_WINDOW", False));
  XSendEvent(window_->display, window_->window, False, NoEventMask, &event);
  XSync(window_->display, False);
}

Image XHands::picture() const {
  XWindowAttributes size{};
  // XGetImage fails fatally for a window that is not mapped yet.
  if (!XGetWindowAttributes(window_->display, window_->window, &size) || size.map_state != IsViewable)
    return {};
  XImage* read = XGetImage(window_->display, window_->window, 0, 0, static_cast<unsigned>(size.width),
                           static_cast<unsigned>(size.height), AllPlanes, ZPixmap);
  if (!read) return {};
  Image image{size.width, size.height, {}};
  image.pixels.assign(size_t{4} * size.width * size.height, 1.0f);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const unsigned long pixel = XGetPixel(read, x, y);  // 24 bits, set by Screen
      for (int c = 0; c < 3; ++c)
        image.at(x, y)[c] = static_cast<float>((pixel >> (16 - 8 * c)) & 0xff) / 255.0f;
    }
  }
  XDestroyImage(read);
  return image;
}

}  // namespace livegs
