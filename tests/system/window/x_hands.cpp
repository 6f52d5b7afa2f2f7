// SPDX-License-Identifier: Apache-2.0
#include "system/window/x_hands.h"

#include <X11/Xlib.h>
#include <X11/Xutil.h>

#include <chrono>
#include <cmath>
#include <thread>

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

void XHands::place(int x_px, int y_px) {
  XMoveWindow(window_->display, window_->window, x_px, y_px);
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

bool XHands::drop_files(const std::vector<std::string>& files, double x_px, double y_px) const {
  Display* const display = XOpenDisplay(DisplayString(window_->display));
  if (!display) return false;
  const auto atom = [&](const char* name) { return XInternAtom(display, name, False); };
  const ::Window root = DefaultRootWindow(display), target = window_->window,
                 source = XCreateSimpleWindow(display, root, 0, 0, 1, 1, 0, 0, 0);
  const Atom list = atom("text/uri-list"), selection = atom("XdndSelection");
  XSetSelectionOwner(display, selection, source, CurrentTime);
  int x = 0, y = 0;
  ::Window child = 0;
  XTranslateCoordinates(display, target, root, static_cast<int>(x_px), static_cast<int>(y_px), &x, &y,
                        &child);
  const auto tell = [&](const char* message, const std::vector<long>& data) {
    XEvent event{};
    event.type = ClientMessage;
    event.xclient.window = target;
    event.xclient.message_type = atom(message);
    event.xclient.format = 32;
    event.xclient.data.l[0] = static_cast<long>(source);
    for (size_t i = 0; i < data.size(); ++i) event.xclient.data.l[i + 1] = data[i];
    XSendEvent(display, target, False, NoEventMask, &event);
    XFlush(display);
  };
  std::string text;
  for (const std::string& file : files) text += "file://" + file + "\r\n";
  tell("XdndEnter", {5L << 24, static_cast<long>(list), 0, 0});
  tell("XdndPosition",
       {0, (static_cast<long>(x) << 16) | y, CurrentTime, static_cast<long>(atom("XdndActionCopy"))});
  bool taken = false;
  for (int waits = 0; waits < 1000 && !taken; ++waits) {
    while (XPending(display) > 0) {
      XEvent event{};
      XNextEvent(display, &event);
      if (event.type == ClientMessage && event.xclient.message_type == atom("XdndStatus"))
        tell("XdndDrop", {0, CurrentTime, 0, 0});
      taken = taken || (event.type == ClientMessage && event.xclient.message_type == atom("XdndFinished"));
      if (event.type != SelectionRequest) continue;
      const XSelectionRequestEvent& asked = event.xselectionrequest;
      XChangeProperty(display, asked.requestor, asked.property, asked.target, 8, PropModeReplace,
                      reinterpret_cast<const unsigned char*>(text.data()), static_cast<int>(text.size()));
      XEvent reply{};
      reply.type = SelectionNotify;
      reply.xselection.requestor = asked.requestor;
      reply.xselection.selection = asked.selection;
      reply.xselection.target = asked.target;
      reply.xselection.property = asked.property;
      reply.xselection.time = asked.time;
      XSendEvent(display, asked.requestor, False, NoEventMask, &reply);
      XFlush(display);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  XCloseDisplay(display);
  return taken;
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
