// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "core/clock.h"
#include "core/log.h"
#include "core/text/format_text.h"
#include "stream/received/frame_history.h"
#include "stream/replay/recording_playback.h"
#include "viewer/camera/initial_camera.h"
#include "viewer/camera/window_picture.h"
#include "viewer/live/connected_scene.h"
#include "viewer/runs/replay_run.h"
#include "xr/window/draw_panels.h"
#include "xr/window_display.h"

namespace livegs {
namespace {

constexpr double kJump_s = 5;
constexpr const char* kReplayHelp =
    "right: rotate   middle: pan\nwheel: zoom   WASDQE: fly\nP: pause   full stop: step\n"
    "arrows: back/forward 5 s\nHome: restart   H: hide panels";

class ReplayWindow {
 public:
  ReplayWindow(const ReplayOptions& options, RecordingPlayback& playback, AssetLibrary& assets,
               SceneView& view, WindowDisplay& display)
      : options_(options),
        playback_(playback),
        assets_(assets),
        view_(view),
        display_(display),
        picture_(options.full_size ? kUnlimitedBudget_ms : window_budget_ms(display.refresh_hz())) {}

  Result<void> run(const std::atomic<bool>& interrupted) {
    if (auto begun = go_to(options_.from_s); !begun) return begun;
    if (auto framed = frame_camera(); !framed) return framed;
    while (!interrupted) {
      const Eigen::Vector2i size = display_.size_px();
      display_.set_camera(camera_.camera(size.x(), size.y()));
      display_.set_wait(wait_s());
      const auto planned = display_.wait_frame();
      if (!planned) break;
      if (auto acted = act(display_.input()); !acted) return acted;
      if (auto reached = reach(moment_ns_); !reached) return reached;
      if (auto posed = view_.pose(*history_.at(moment_ns_)); !posed) return posed;
      if (auto drawn = picture_.draw(view_, camera_, display_.size_px(), now_ns()); !drawn) return drawn;
      display_.set_overlay(overlay());
      if (options_.on_picture) display_.keep_next(screenshot_);
      if (auto submitted = display_.submit(*planned, picture_.drawn()); !submitted) return submitted;
      if (options_.on_picture) options_.on_picture(screenshot_, {shown_s(), paused_, ended()});
      if (options_.seconds > 0 && shown_s() >= options_.from_s + options_.seconds) break;
      if (options_.seconds > 0 && ended()) break;
    }
    return {};
  }

 private:
  double shown_s() const { return seconds_from_ns(moment_ns_ - first_ns_); }
  bool ended() const { return at_end_ && moment_ns_ >= history_.newest().simulated_ns; }

  // Time for which the window may wait for events.
  double wait_s() const {
    const double wait_s = picture_.wait_s(now_ns());
    return paused_ || ended() ? wait_s : std::min(wait_s, StillPicture::kAlertWait_s);
  }

  Result<void> frame_camera() {
    const Eigen::Vector2i size = display_.size_px();
    if (auto posed = view_.pose(history_.newest()); !posed) return posed;
    const auto free = columns_beside_panels(size.x(), true, display_.ui_scale());
    const auto camera =
        initial_camera(view_, {size.x(), size.y()}, options_.camera_file,
                       free ? std::optional(PictureColumns{free->first, free->second}) : std::nullopt);
    if (!camera) return camera.error();
    camera_ = orbit_of(view_, *camera);
    return {};
  }

  // Shows this time next.
  Result<void> go_to(double seconds) {
    seconds = std::clamp(seconds, 0.0, playback_.length_s());
    if (auto sought = playback_.seek(seconds); !sought) return sought;
    history_ = FrameHistory(kFramesKept);
    at_end_ = false;
    if (auto taken = take_frame(); !taken) return taken;
    if (history_.empty())
      return invalid_data(options_.file.string() +
                          ": the recording has no frame; check it with livegs ctl replay FILE");
    moment_ns_ = history_.newest().simulated_ns;
    first_ns_ = moment_ns_ - static_cast<int64_t>(1e9 * seconds);
    return {};
  }

  // Takes items up to and including the next frame.
  Result<void> take_frame() {
    while (auto item = playback_.take()) {
      if (auto* frame = std::get_if<ReceivedFrame>(&*item)) {
        tick_ = frame->tick;
        history_.add(*frame->drivers);
        return {};
      }
      if (auto shown = take_object(*item); !shown) return shown;
    }
    if (!at_end_ && playback_.error()) log_warn("%s", playback_.error()->message.c_str());
    at_end_ = true;
    return {};
  }

  Result<void> take_object(const StreamItem& item) {
    if (const auto* removed = std::get_if<ObjectRemoved>(&item)) {
      view_.remove(removed->object_id);
      return {};
    }
    const auto* added = std::get_if<ObjectAdded>(&item);
    const StreamedObject& object = added ? added->object : std::get<ObjectChanged>(item).object;
    assets_.request(object);
    auto asset = assets_.get(object.asset_hash);
    if (!asset) return asset.error();
    return added ? view_.add(object.id, *asset, object.rest, object.environment)
                 : view_.change(object.id, *asset, object.rest, object.environment);
  }

  Result<void> reach(int64_t moment_ns) {
    while (!at_end_ && history_.newest().simulated_ns < moment_ns) {
      if (auto taken = take_frame(); !taken) return taken;
    }
    history_.drop_before(moment_ns);
    moment_ns_ = std::min(moment_ns_, history_.newest().simulated_ns);
    return {};
  }

  Result<void> act(const WindowInput& input) {
    const double height = display_.size_px().y();
    if (input.right) camera_.orbit(input.moved_px, height);
    if (input.middle) camera_.pan(input.moved_px, height);
    if (input.scrolled != 0) camera_.zoom(input.scrolled);
    camera_.fly(input.flown, input.passed_s);
    if (input.hide) panels_shown_ = !panels_shown_;
    const PanelActions& actions = display_.actions();
    if (actions.pause || input.pause) paused_ = actions.pause.value_or(!paused_);
    if (input.home || actions.reset) return go_to(0);
    if (input.jump != 0) return go_to(shown_s() + kJump_s * input.jump);
    if (const int steps = input.step + (actions.step ? 1 : 0); steps > 0) {
      paused_ = true;
      for (int step = 0; step < steps; ++step) {
        if (moment_ns_ >= history_.newest().simulated_ns) {  // else playback was paused before that frame
          if (auto taken = take_frame(); !taken) return taken;
        }
        moment_ns_ = history_.newest().simulated_ns;
      }
    } else if (!paused_) {
      moment_ns_ += static_cast<int64_t>(1e9 * input.passed_s);
    }
    return {};
  }

  WindowOverlay overlay() const {
    WindowOverlay overlay;
    overlay.panels.shown = panels_shown_;
    overlay.panels.run.recorded = true;
    overlay.panels.run.paused = paused_;
    overlay.panels.run.notice = playback_.error() ? playback_.error()->message : view_.notice();
    overlay.panels.run.lines.push_back("recording " + options_.file.filename().string());
    overlay.panels.run.lines.push_back(format_text(
        "%.2f s of %.1f s, tick %llu%s%s", shown_s(), playback_.length_s(),
        static_cast<unsigned long long>(tick_), paused_ ? ", paused" : "", at_end_ ? ", at the end" : ""));
    overlay.panels.run.lines.push_back(view_.renderer_name());
    overlay.panels.run.lines.push_back(picture_.text());
    overlay.panels.run.help = kReplayHelp;
    return overlay;
  }

  static constexpr size_t kFramesKept = 8;
  const ReplayOptions& options_;
  RecordingPlayback& playback_;
  AssetLibrary& assets_;
  SceneView& view_;
  WindowDisplay& display_;
  OrbitCamera camera_;
  WindowPicture picture_;
  FrameHistory history_{kFramesKept};
  int64_t first_ns_ = 0, moment_ns_ = 0;  // simulated time of the first frame and of the picture
  uint64_t tick_ = 0;
  bool paused_ = false, at_end_ = false, panels_shown_ = true;
  Image screenshot_;
};

}  // namespace

Result<void> run_replay_window(const ReplayOptions& options, const std::atomic<bool>& interrupted) {
  auto playback = RecordingPlayback::open(options.file);
  if (!playback) return playback.error();
  if (auto checked = check_from(options, playback->length_s()); !checked) return checked;
  const PictureSize size = options.size.value_or(PictureSize{1280, 800});
  auto display = WindowDisplay::open("LiveGS " + options.file.filename().string(), size.width, size.height,
                                     options.ui_scale, !options.size);
  if (!display) return display.error();
  const auto cache = asset_cache(options.cache);
  if (!cache) return cache.error();
  auto renderer = choose_renderer(options.renderer);
  if (!renderer) return renderer.error();
  AssetLibrary assets(assets_of_recording(options.file), *cache);
  SceneView view(*std::move(renderer));
  view.set_shadows(options.shadows);
  return ReplayWindow(options, *playback, assets, view, **display).run(interrupted);
}

}  // namespace livegs
