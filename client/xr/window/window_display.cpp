// SPDX-License-Identifier: Apache-2.0
#include "xr/window_display.h"

#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl2.h>
#include <imgui.h>

#include <algorithm>
#include <cfloat>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <thread>
#include <utility>

#include "core/assert.h"
#include "core/sanitizers.h"
#include "xr/window/draw_panels.h"
#include "xr/window/window_events.h"
#include "xr/window/window_style.h"

namespace livegs {
namespace {

// Shortest time between two frames that waited for events, seconds: a mouse may send a thousand a second.
constexpr double kMinWaitedFrame_s = 1.0 / 120;
// Number of frames with short waits after a change of the contents: Dear ImGui gives a panel its size over a
// few frames. Fewer leave a panel at a wrong size until the next event.
constexpr int kSettlingFrames = 3;
constexpr double kSettlingWait_s = 0.01;

std::string glfw_error() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text ? text : "no reason given";
}

// All that determines the contents of a window, apart from its textures.
std::vector<uint8_t> drawn_bytes(const ImDrawData& data, int width, int height) {
  std::vector<uint8_t> bytes;
  const auto add = [&](const void* from, size_t count) {
    const auto* first = static_cast<const uint8_t*>(from);
    bytes.insert(bytes.end(), first, first + count);
  };
  add(&width, sizeof width);
  add(&height, sizeof height);
  for (int i = 0; i < data.CmdListsCount; ++i) {
    const ImDrawList& list = *data.CmdLists[i];
    add(list.VtxBuffer.Data, sizeof(ImDrawVert) * static_cast<size_t>(list.VtxBuffer.Size));
    add(list.IdxBuffer.Data, sizeof(ImDrawIdx) * static_cast<size_t>(list.IdxBuffer.Size));
    for (const ImDrawCmd& command : list.CmdBuffer) {
      add(&command.ClipRect, sizeof command.ClipRect);
      add(&command.TextureId, sizeof command.TextureId);
      add(&command.ElemCount, sizeof command.ElemCount);
    }
  }
  return bytes;
}

class GlfwWindowDisplay final : public WindowDisplay {
 public:
  ~GlfwWindowDisplay() override;
  Result<void> create(const std::string& title, int width, int height, double ui_scale, bool scaled_size);

  std::optional<PlannedFrame> wait_frame() override;
  Result<void> submit(const PlannedFrame& frame, std::span<const Image> images) override;
  Result<void> finish() override { return {}; }

  void set_camera(const Camera& camera) override { camera_ = camera; }
  void set_wait(double seconds) override { wait_s_ = seconds; }
  void wake() override { glfwPostEmptyEvent(); }
  const WindowInput& input() const override { return input_; }
  Eigen::Vector2i size_px() const override;
  double ui_scale() const override { return ui_scale_; }
  double refresh_hz() const override;
  void set_overlay(WindowOverlay overlay) override { overlay_ = std::move(overlay); }
  const PanelActions& actions() const override { return actions_; }
  void keep_next(Image& image) override { kept_ = &image; }

 private:
  void follow_scale();
  void take_events();
  void take_input();
  void wait_for_events();
  void load_picture(const Image& image);
  void draw_picture();
  void draw_overlay();
  void read_back(Image& image) const;
  Eigen::Vector2d cursor_px() const;
  static GlfwWindowDisplay& of(GLFWwindow* window) {
    return *static_cast<GlfwWindowDisplay*>(glfwGetWindowUserPointer(window));
  }

  bool initialised_ = false, panels_ = false;
  double wanted_scale_ = 0, ui_scale_ = 0;  // wanted: 0 is that of the monitor
  GLFWwindow* window_ = nullptr;
  GLuint texture_ = 0;
  Camera camera_;
  WindowInput input_;
  WindowOverlay overlay_;
  PanelDrawer drawer_;
  PanelActions actions_;
  WindowEvents events_;
  std::vector<std::string> dropped_;  // since the last picture
  double last_s_ = 0, wait_s_ = 0;
  int settling_ = 0;            // frames with short waits
  bool damaged_ = true;         // the system lost contents of the window
  std::vector<uint8_t> shown_;  // drawn_bytes() of the contents
  uint64_t planned_ = 0;
  Image* kept_ = nullptr;
};

GlfwWindowDisplay::~GlfwWindowDisplay() {
  if (panels_) {
    ImGui_ImplOpenGL2_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
  }
  if (texture_) glDeleteTextures(1, &texture_);
  if (window_) glfwDestroyWindow(window_);
  if (initialised_) glfwTerminate();
}

Result<void> GlfwWindowDisplay::create(const std::string& title, int width, int height, double ui_scale,
                                       bool scaled_size) {
  [[maybe_unused]] const IgnoredLeaks of_drivers;  // which keep memory until the process ends
  if (!glfwInit()) {
    return Error{ErrorCode::Unavailable, "window: no display is available (" + glfw_error() +
                                             "); set DISPLAY, or use --display offscreen"};
  }
  initialised_ = true;
  wanted_scale_ = ui_scale;
  glfwWindowHint(GLFW_SCALE_TO_MONITOR, scaled_size ? GLFW_TRUE : GLFW_FALSE);
  window_ = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
  if (!window_) {
    return Error{ErrorCode::Unavailable,
                 "window: opening failed (" + glfw_error() + "); install OpenGL, or use --display offscreen"};
  }
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(1);
  glfwSetWindowUserPointer(window_, this);
  // ImGui's callbacks, which are installed below, call these.
  glfwSetKeyCallback(window_, [](GLFWwindow* window, int key, int, int action, int) {
    if (action != GLFW_REPEAT) of(window).events_.on_key(key, action == GLFW_PRESS);
  });
  glfwSetMouseButtonCallback(window_, [](GLFWwindow* window, int button, int action, int) {
    of(window).events_.on_button(button, action == GLFW_PRESS, of(window).cursor_px());
  });
  glfwSetDropCallback(window_, [](GLFWwindow* window, int count, const char** paths) {
    of(window).dropped_.insert(of(window).dropped_.end(), paths, paths + count);
  });
  glfwSetWindowRefreshCallback(window_, [](GLFWwindow* window) { of(window).damaged_ = true; });
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;  // ImGui must not write a file to the working directory
  panels_ = ImGui_ImplGlfw_InitForOpenGL(window_, true) && ImGui_ImplOpenGL2_Init();
  follow_scale();
  glGenTextures(1, &texture_);
  last_s_ = glfwGetTime();
  return {};
}

Eigen::Vector2i GlfwWindowDisplay::size_px() const {
  int width = 0, height = 0;
  glfwGetWindowSize(window_, &width, &height);
  return {std::max(1, width), std::max(1, height)};
}

// Takes the scale of the monitor, which changes when the window is moved to another one. Where a window has
// coordinates other than pixels, they already include a part of it.
void GlfwWindowDisplay::follow_scale() {
  double scale = wanted_scale_;
  if (scale == 0) {
    float content = 1;
    int pixels = 0, height = 0;
    glfwGetWindowContentScale(window_, &content, nullptr);
    glfwGetFramebufferSize(window_, &pixels, &height);
    scale = pixels > 0 ? content * size_px().x() / pixels : content;
  }
  scale = std::clamp(scale, kMinUiScale, kMaxUiScale);
  if (scale == ui_scale_) return;
  ui_scale_ = scale;
  set_window_style(static_cast<float>(scale));
  ImGui_ImplOpenGL2_DestroyFontsTexture();  // made again by the next frame
}

double GlfwWindowDisplay::refresh_hz() const {
  int left = 0, top = 0, count = 0;
  glfwGetWindowPos(window_, &left, &top);
  const Eigen::AlignedBox2i window(Eigen::Vector2i(left, top), Eigen::Vector2i(left, top) + size_px());
  GLFWmonitor** monitors = glfwGetMonitors(&count);
  int64_t max_px = -1;
  double hz = 0;
  for (int i = 0; i < count; ++i) {
    const GLFWvidmode* mode = glfwGetVideoMode(monitors[i]);
    if (!mode) continue;
    glfwGetMonitorPos(monitors[i], &left, &top);
    const Eigen::AlignedBox2i seen = window.intersection(
        {Eigen::Vector2i(left, top), Eigen::Vector2i(left + mode->width, top + mode->height)});
    const int64_t px = seen.isEmpty() ? 0 : int64_t{seen.sizes().x()} * seen.sizes().y();
    if (px <= max_px) continue;
    max_px = px;
    hz = mode->refreshRate;
  }
  return hz;
}

Eigen::Vector2d GlfwWindowDisplay::cursor_px() const {
  Eigen::Vector2d at(0, 0);
  glfwGetCursorPos(window_, &at.x(), &at.y());
  return at;
}

// Takes the events since the last picture. ImGui's backend reads the current state, in which a short press
// has passed; it is replaced by that of the events.
void GlfwWindowDisplay::take_events() {
  events_.begin_picture(cursor_px());
  ImGuiIO& io = ImGui::GetIO();
  const WindowEvents::Mouse& mouse = events_.mouse();
  if (io.MousePos.x > -FLT_MAX)  // ImGui's mark for a window without the mouse
    io.MousePos = {static_cast<float>(mouse.position_px.x()), static_cast<float>(mouse.position_px.y())};
  for (int i = 0; i < WindowEvents::kButtons; ++i) io.MouseDown[i] = mouse.down[i];
  for (const int key : events_.used_keys()) {
    if (key >= 0 && key < IM_ARRAYSIZE(io.KeysDown)) io.KeysDown[key] = events_.held(key);
  }
}

void GlfwWindowDisplay::take_input() {
  const ImGuiIO& io = ImGui::GetIO();
  const WindowEvents::Mouse& mouse = events_.mouse();
  const double now_s = glfwGetTime();
  WindowInput taken;
  if (planned_ > 0)
    taken.passed_s = now_s - last_s_;  // else the time includes the loading since the window was opened
  last_s_ = now_s;
  taken.mouse_px = mouse.position_px;
  const bool pressed = std::find(mouse.pressed.begin(), mouse.pressed.end(), true) != mouse.pressed.end();
  // A drag starts where the button went down.
  taken.moved_px =
      planned_ == 0 || pressed ? Eigen::Vector2d(0, 0) : Eigen::Vector2d(taken.mouse_px - input_.mouse_px);
  taken.over_panel = io.WantCaptureMouse;
  if (!io.WantCaptureMouse) {
    taken.left = mouse.down[GLFW_MOUSE_BUTTON_LEFT];
    taken.middle = mouse.held[GLFW_MOUSE_BUTTON_MIDDLE];
    taken.right = mouse.held[GLFW_MOUSE_BUTTON_RIGHT];
    taken.scrolled = io.MouseWheel;
  }
  if (!io.WantCaptureKeyboard) {
    const auto axis = [&](int plus, int minus) {
      return events_.held_share(plus, taken.passed_s) - events_.held_share(minus, taken.passed_s);
    };
    taken.flown = {axis(GLFW_KEY_D, GLFW_KEY_A), axis(GLFW_KEY_E, GLFW_KEY_Q), axis(GLFW_KEY_S, GLFW_KEY_W)};
    taken.shoot = events_.presses(GLFW_KEY_SPACE);
    taken.hide = events_.toggled(GLFW_KEY_H);
    taken.pause = events_.toggled(GLFW_KEY_P);
    taken.step = events_.presses(GLFW_KEY_PERIOD);
    taken.home = events_.presses(GLFW_KEY_HOME) > 0;
    taken.jump = events_.presses(GLFW_KEY_RIGHT) - events_.presses(GLFW_KEY_LEFT);
    taken.ctrl = events_.held(GLFW_KEY_LEFT_CONTROL) || events_.held(GLFW_KEY_RIGHT_CONTROL);
    if (taken.ctrl) {
      const bool shift = events_.held(GLFW_KEY_LEFT_SHIFT) || events_.held(GLFW_KEY_RIGHT_SHIFT);
      (shift ? taken.redo : taken.undo) = events_.presses(GLFW_KEY_Z);
      taken.redo += events_.presses(GLFW_KEY_Y);
      taken.save = events_.presses(GLFW_KEY_S);
      taken.duplicate = events_.presses(GLFW_KEY_D);
      taken.flown.setZero();  // their letters fly without Ctrl
    } else {
      taken.remove = events_.presses(GLFW_KEY_DELETE);
      taken.frame = events_.presses(GLFW_KEY_F) > 0;
      for (int tool = 0; tool < 6; ++tool) {
        if (events_.presses(GLFW_KEY_1 + tool) > 0) taken.tool = tool;
      }
    }
  }
  taken.dropped = std::exchange(dropped_, {});
  input_ = std::move(taken);
}

void GlfwWindowDisplay::wait_for_events() {
  double wait_s = std::exchange(wait_s_, 0);
  if (settling_ > 0) {
    --settling_;
    wait_s = std::min(wait_s, kSettlingWait_s);
  }
  if (wait_s > 0 && !events_.waiting()) {
    glfwWaitEventsTimeout(wait_s);
    const double early_s = last_s_ + kMinWaitedFrame_s - glfwGetTime();
    if (early_s > 0) std::this_thread::sleep_for(std::chrono::duration<double>(early_s));
  }
  glfwPollEvents();
}

std::optional<PlannedFrame> GlfwWindowDisplay::wait_frame() {
  wait_for_events();
  if (glfwWindowShouldClose(window_)) return std::nullopt;
  follow_scale();
  ImGui_ImplOpenGL2_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  take_events();
  ImGui::NewFrame();
  take_input();
  PlannedFrame frame;
  frame.index = planned_++;
  frame.display_time_ns = static_cast<int64_t>(std::llround(glfwGetTime() * 1e9));
  frame.views = {camera_};
  return frame;
}

void GlfwWindowDisplay::load_picture(const Image& image) {
  const std::vector<uint8_t> bytes = rgb_bytes(image);
  glBindTexture(GL_TEXTURE_2D, texture_);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB, image.width, image.height, 0, GL_RGB, GL_UNSIGNED_BYTE,
               bytes.data());
}

void GlfwWindowDisplay::draw_picture() {
  const Eigen::Vector2i size = size_px();
  ImGui::GetBackgroundDrawList()->AddImage(reinterpret_cast<ImTextureID>(static_cast<intptr_t>(texture_)),
                                           {0, 0},
                                           {static_cast<float>(size.x()), static_cast<float>(size.y())});
}

void GlfwWindowDisplay::draw_overlay() {
  ImDrawList& over = *ImGui::GetBackgroundDrawList();  // above the picture, below the panels
  const Eigen::Vector2i size = size_px();
  for (const WindowLine& line : overlay_.lines) draw_line(over, line);
  for (const WindowArrow& arrow : overlay_.arrows) draw_arrow(over, arrow);
  if (overlay_.aim) draw_aim(over, *overlay_.aim);
  if (!overlay_.sentence.empty()) draw_sentence(over, size.cast<double>(), overlay_.sentence);
  actions_ = drawer_.draw(overlay_.panels, static_cast<float>(size.x()), static_cast<float>(size.y()));
}

Result<void> GlfwWindowDisplay::submit(const PlannedFrame&, std::span<const Image> images) {
  LIVEGS_ASSERT(images.size() <= 1);
  if (!images.empty()) load_picture(images[0]);
  draw_picture();
  draw_overlay();
  ImGui::Render();
  int width = 0, height = 0;
  glfwGetFramebufferSize(window_, &width, &height);
  std::vector<uint8_t> drawn = drawn_bytes(*ImGui::GetDrawData(), width, height);
  const bool changed = drawn != shown_;
  if (changed) settling_ = kSettlingFrames;
  if (images.empty() && !kept_ && !damaged_ && !changed) return {};
  shown_ = std::move(drawn);
  damaged_ = false;
  glViewport(0, 0, width, height);
  glClear(GL_COLOR_BUFFER_BIT);
  ImGui_ImplOpenGL2_RenderDrawData(ImGui::GetDrawData());
  if (kept_)
    read_back(*std::exchange(kept_, nullptr));  // before the swap, after which the contents are undefined
  glfwSwapBuffers(window_);
  return {};
}

void GlfwWindowDisplay::read_back(Image& image) const {
  glfwGetFramebufferSize(window_, &image.width, &image.height);
  const size_t row = size_t{3} * image.width;
  std::vector<uint8_t> bytes(row * image.height);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadBuffer(GL_BACK);
  glReadPixels(0, 0, image.width, image.height, GL_RGB, GL_UNSIGNED_BYTE, bytes.data());
  image.pixels.assign(size_t{4} * image.width * image.height, 1.0f);
  for (int y = 0; y < image.height; ++y) {  // OpenGL stores the bottom row first
    const uint8_t* from = bytes.data() + row * static_cast<size_t>(image.height - 1 - y);
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < 3; ++c) image.at(x, y)[c] = static_cast<float>(from[3 * x + c]) / 255.0f;
    }
  }
}

}  // namespace

bool WindowDisplay::is_possible() {
  [[maybe_unused]] const IgnoredLeaks of_drivers;
  if (!glfwInit()) return false;
  glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
  GLFWwindow* window = glfwCreateWindow(16, 16, "", nullptr, nullptr);
  if (window) glfwDestroyWindow(window);
  glfwTerminate();  // also resets the hint
  return window != nullptr;
}

Result<std::unique_ptr<WindowDisplay>> WindowDisplay::open(const std::string& title, int width, int height,
                                                           double ui_scale, bool scaled_size) {
  auto display = std::make_unique<GlfwWindowDisplay>();
  if (auto made = display->create(title, width, height, ui_scale, scaled_size); !made) return made.error();
  return Result<std::unique_ptr<WindowDisplay>>(std::move(display));
}

}  // namespace livegs
