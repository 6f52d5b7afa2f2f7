// SPDX-License-Identifier: Apache-2.0
#include "viewer/window_run.h"

#include <cmath>
#include <cstdio>
#include <map>

#include "core/clock.h"
#include "core/log.h"
#include "render/choose_camera.h"
#include "stream/scripted_hands.h"
#include "stream/session_client.h"
#include "viewer/live_stream.h"
#include "viewer/load_scene.h"
#include "viewer/object_line.h"
#include "viewer/orbit_camera.h"
#include "viewer/render_scale.h"
#include "xr/window_display.h"

namespace livegs {
namespace {

constexpr double kBudget_ms = 30;        // of a picture; what is slower is drawn smaller
constexpr double kMetresANewton = 0.01;  // of the force arrow
constexpr size_t kRightHand = 1;

std::string text(const char* format, auto... values) {
  char line[256];
  std::snprintf(line, sizeof line, format, values...);
  return line;
}

class WindowRun {
 public:
  WindowRun(const WindowRunOptions& options, SessionClient& client, AssetLibrary& assets, SceneView& view,
            WindowDisplay& display)
      : options_(options), client_(client), stream_(assets), view_(view), display_(display) {
    for (const StreamedObject& object : client.scene().objects) objects_[object.id] = object;
  }

  Result<void> run(const std::atomic<bool>& interrupted);

 private:
  Result<void> take_news();
  Result<void> first_frame();
  void move_camera(const WindowInput& input);
  void send_hands(const WindowInput& input);
  void send_script();
  WindowOverlay overlay(const Camera& window) const;
  Result<void> keep_screenshot();

  const WindowRunOptions& options_;
  SessionClient& client_;
  LiveStream stream_;
  SceneView& view_;
  WindowDisplay& display_;

  std::map<uint32_t, StreamedObject> objects_;
  std::optional<ReceivedFrame> frame_;
  std::optional<OrbitCamera> camera_;
  std::optional<ScriptedHands> script_;
  InputSample sample_;
  RenderScale scale_{kBudget_ms};
  std::string notice_ = "waiting for the first frame";
  bool over_ = false;
  int64_t begun_ns_ = 0;
  double frames_a_second_ = 0, shown_a_second_ = 0, age_ms_ = 0;
  Image screenshot_;
  int screenshots_ = 0;
};

Result<void> WindowRun::first_frame() {
  const Eigen::Vector2i size = display_.size_px();
  if (auto posed = view_.pose(*frame_->drivers); !posed) return posed;
  Camera camera = choose_camera(view_, size.x(), size.y());
  if (!options_.camera_file.empty()) {
    auto read = read_camera_file(options_.camera_file, PictureSize{size.x(), size.y()});
    if (!read) return read.error();
    camera = *read;
  }
  Eigen::AlignedBox3d all;
  for (const Eigen::AlignedBox3d& box : view_.object_boxes()) all.extend(box);
  const Eigen::Vector3d eye = camera.world_from_camera.position_m;
  camera_.emplace(camera, all.isEmpty() ? 1.0 : (all.center() - eye).norm());
  if (!options_.poke.empty())
    script_.emplace(poke_script(options_.poke), ScriptedHands::Settings{eye, client_.scene().ball_speed_m_s});
  begun_ns_ = now_ns();
  notice_.clear();
  return {};
}

Result<void> WindowRun::take_news() {
  auto news = stream_.take(view_);
  if (!news) return news.error();
  for (StreamedObject& object : news->described) objects_[object.id] = std::move(object);
  for (const uint32_t id : news->removed) objects_.erase(id);
  if (news->back) notice_.clear();
  if (news->goodbye) notice_ = "the server says goodbye: " + *news->goodbye;
  // What it said itself stays.
  if (news->lost && notice_.rfind("the server says", 0) != 0) {
    notice_ = "the server has gone: " + *news->lost + "; looking for it";
    log_warn("%s", notice_.c_str());
  }
  if (client_.ended() && !over_) {
    over_ = true;
    const auto stopped = client_.stop();
    notice_ = "the session is over" + (stopped ? std::string() : ": " + stopped.error().message);
    log_warn("%s", notice_.c_str());
  }
  if (!news->frame) return {};
  frame_ = std::move(news->frame);
  age_ms_ = milliseconds_from_ns(now_ns() - frame_->received_ns);
  return camera_ ? Result<void>() : first_frame();
}

void WindowRun::move_camera(const WindowInput& input) {
  const double height = display_.size_px().y();
  if (input.right) camera_->orbit(input.moved_px, height);
  if (input.middle) camera_->pan(input.moved_px, height);
  if (input.scrolled != 0) camera_->zoom(input.scrolled);
  camera_->fly(input.flown, input.passed_s);
}

void WindowRun::send_hands(const WindowInput& input) {
  const Eigen::Vector2i size = display_.size_px();
  HandSample& hand = sample_.hands[kRightHand];
  hand.active = true;
  hand.aim = ray_through(camera_->camera(size.x(), size.y()), input.mouse_px);
  hand.grip = hand.aim;
  hand.trigger = input.left ? 1.0f : 0.0f;
  hand.shoot = input.shoot;
  ++sample_.sequence;
  sample_.sampled_ns = now_ns();
  client_.send(sample_);
}

void WindowRun::send_script() {
  const auto locate = [&](const std::string& name) -> std::optional<ObjectExtent> {
    for (const auto& [id, object] : objects_) {
      const Eigen::AlignedBox3d box = view_.bounds(id);
      if (object.name == name && !box.isEmpty()) return ObjectExtent{box.center(), box.sizes().maxCoeff()};
    }
    return std::nullopt;
  };
  client_.send(script_->at(seconds_from_ns(now_ns() - begun_ns_), locate));
}

WindowOverlay WindowRun::overlay(const Camera& window) const {
  WindowOverlay overlay;
  if (!notice_.empty()) overlay.status.push_back(notice_);
  overlay.status.push_back(view_.renderer_name());
  overlay.status.push_back(text("%.0f pictures a second of %.0f frames, drawn at %.0f %%", shown_a_second_,
                                frames_a_second_, 100.0 * scale_.value()));
  overlay.status.push_back(text("skin %.1f ms, render %.1f ms, frame %.1f ms old", view_.last_times().skin_ms,
                                view_.last_times().raster_ms, age_ms_));
  overlay.status.push_back(
      "left: pull  right: turn  middle: shift  wheel: nearer  WASDQE: fly  space: shoot");
  for (const auto& [id, object] : objects_) {
    if (!object.environment) overlay.objects.push_back(object_line(object));
  }
  if (!frame_) return overlay;
  for (const HeldByHand& held : frame_->hands) {
    const Eigen::Vector3d point = held.point_m.cast<double>(), force = held.force_n.cast<double>();
    const auto from = pixel_of(window, point), to = pixel_of(window, point + kMetresANewton * force);
    if (from && to) overlay.arrows.push_back({*from, *to, text("%.1f N", force.norm())});
  }
  return overlay;
}

Result<void> WindowRun::keep_screenshot() {
  char name[32];
  std::snprintf(name, sizeof name, "window_%03d.png", screenshots_++);
  return write_png(options_.screenshots / name, screenshot_);
}

Result<void> WindowRun::run(const std::atomic<bool>& interrupted) {
  client_.start(stream_);
  begun_ns_ = now_ns();
  std::vector<Image> pictures;
  int64_t second_ns = now_ns();
  uint64_t shown = 0, first_tick = 0;
  while (!interrupted) {
    if (auto taken = take_news(); !taken) return taken;
    const Eigen::Vector2i size = display_.size_px();
    if (camera_) display_.set_camera(camera_->camera(scale_.of(size.x()), scale_.of(size.y())));
    const auto planned = display_.wait_frame();
    if (!planned) break;
    if (camera_) {
      move_camera(display_.input());
      script_ ? send_script() : send_hands(display_.input());
      if (auto drawn = view_.draw(*frame_->drivers, planned->views, pictures); !drawn) return drawn;
      scale_.drew(view_.last_times().raster_ms);
      display_.set_overlay(overlay(camera_->camera(size.x(), size.y())));
    } else {
      pictures.assign(1, Image{1, 1, {0.08f, 0.08f, 0.1f, 1.0f}});
      display_.set_overlay(overlay({}));
    }
    const bool second_is_over = now_ns() - second_ns >= 1'000'000'000;
    const bool keeps = second_is_over && !options_.screenshots.empty() && camera_;
    if (keeps) display_.keep_next(screenshot_);
    if (auto submitted = display_.submit(*planned, pictures); !submitted) return submitted;
    ++shown;
    const int64_t now = now_ns();
    if (second_is_over) {
      const double passed_s = seconds_from_ns(now - second_ns);
      const uint64_t tick = frame_ ? frame_->tick : 0;
      frames_a_second_ = first_tick == 0 || tick < first_tick ? 0 : static_cast<double>(tick - first_tick) / passed_s;
      shown_a_second_ = static_cast<double>(shown) / passed_s;
      first_tick = tick;
      shown = 0;
      second_ns = now;
      if (keeps) {
        if (auto kept = keep_screenshot(); !kept) return kept;
      }
    }
    // Counted from the first frame, if there is to be one.
    const bool counts = options_.seconds > 0 && (camera_ || client_.ended());
    if (counts && seconds_from_ns(now - begun_ns_) >= options_.seconds) break;
  }
  return {};
}

}  // namespace

Result<void> run_window(const WindowRunOptions& options, const std::atomic<bool>& interrupted) {
  if (!options.screenshots.empty()) {
    std::error_code error;
    std::filesystem::create_directories(options.screenshots, error);
    if (error) return invalid_argument(options.screenshots.string() + ": cannot be made: " + error.message());
  }
  const PictureSize size = options.size.value_or(PictureSize{1280, 800});
  auto display = WindowDisplay::open("LiveGS " + options.address, size.width, size.height);
  if (!display) return display.error();
  ConnectOptions connect;
  connect.timeout_s = options.connect_timeout_s;
  connect.reconnect_s = options.reconnect_s;
  connect.outlive_draining = true;  // it may be started again
  auto joined = SessionClient::join(options.address, connect);
  if (!joined) return joined.error();
  auto renderer = choose_renderer(options.renderer);
  if (!renderer) return renderer.error();
  std::filesystem::path cache_folder = options.cache;
  if (cache_folder.empty()) {
    auto folder = AssetCache::default_folder();
    if (!folder) return folder.error();
    cache_folder = std::move(*folder);
  }
  const AssetCache cache(cache_folder);
  AssetLibrary assets(**joined, cache);
  SceneView view(*std::move(renderer));
  if (auto loaded = load_scene((*joined)->scene(), assets, view); !loaded) return loaded;
  WindowRun run(options, **joined, assets, view, **display);
  const auto done = run.run(interrupted);
  const auto stopped = (*joined)->stop();  // before the run's stream goes, which its reader calls
  if (!stopped) log_warn("%s", stopped.error().message.c_str());
  return done;
}

}  // namespace livegs
