// SPDX-License-Identifier: Apache-2.0
#include "viewer/runs/window_run.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <utility>

#include "core/clock.h"
#include "core/log.h"
#include "core/text/format_text.h"
#include "core/written_files.h"
#include "stream/session/scene_control.h"
#include "stream/session/session_client.h"
#include "viewer/assets/part_colours.h"
#include "viewer/author/author_run.h"
#include "viewer/author/object_pose.h"
#include "viewer/author/scene_lines.h"
#include "viewer/camera/initial_camera.h"
#include "viewer/camera/orbit_camera.h"
#include "viewer/camera/window_picture.h"
#include "viewer/live/control_calls.h"
#include "viewer/live/frame_queue.h"
#include "viewer/live/playout.h"
#include "viewer/live/session_notice.h"
#include "viewer/panels/frame_meter.h"
#include "viewer/panels/object_panel.h"
#include "viewer/runs/loading_window.h"
#include "viewer/runs/mouse_hands.h"
#include "viewer/runs/run_panel.h"
#include "viewer/runs/window_study.h"
#include "xr/window/draw_panels.h"
#include "xr/window_display.h"

namespace livegs {
namespace {

constexpr int kManyScreenshots = 100;  // are worth a warning; they take some 60 MB
// Longest wait while pictures are taken, by a test or for screenshots.
constexpr double kWatchedWait_s = 0.05;

class WindowRun {
 public:
  WindowRun(const WindowRunOptions& options, SessionClient& client, SceneControl& control,
            ProgressiveObjects& arriving, SceneView& view, WindowDisplay& display)
      : options_(options),
        client_(client),
        calls_(control, [&display] { display.wake(); }),
        author_(calls_),
        arriving_(arriving),
        stream_(arriving, [&display] { display.wake(); }),
        view_(view),
        display_(display),
        hands_(client, meter_),
        study_(options.screenshots.empty() ? "out/study" : options.screenshots, client.scene().rate_hz,
               calls_, stream_, view),
        picture_(options.full_size ? kUnlimitedBudget_ms : window_budget_ms(display.refresh_hz())) {
    for (const StreamedObject& object : client.scene().objects) objects_[object.id] = object;
    stream_.hide(client.scene().objects);
  }

  // Finishes a recording in progress before it returns.
  Result<void> run(const std::atomic<bool>& interrupted);

 private:
  Result<void> show(const std::atomic<bool>& interrupted);
  Result<void> poll_updates();
  Result<void> first_frame();
  void move_camera(const WindowInput& input);
  void point(const WindowInput& input, const Camera& window);
  double wait_s() const;
  bool holds() const;
  void send_hands(const WindowInput& input);
  void act(const WindowInput& input);
  void act_on_run(const WindowInput& input, const PanelActions& actions);
  bool ends_with_recording() const { return !options_.forces.empty() && options_.seconds == 0; }
  Result<void> take_answers();
  Result<void> picture();
  Result<void> recorded_picture(const PlannedFrame& planned);
  Eigen::AlignedBox3d rest_bounds(const StreamedObject& object) const;
  void draw_part_boxes(const Camera& window, WindowOverlay& overlay) const;
  WindowOverlay overlay(const Camera& window) const;
  WindowPanels panels() const;
  Result<void> keep_screenshot();
  Camera window_camera() const {
    const Eigen::Vector2i size = display_.size_px();
    return camera_->camera(size.x(), size.y());
  }

  const WindowRunOptions& options_;
  SessionClient& client_;
  ControlCalls calls_;
  AuthorRun author_;
  const ProgressiveObjects& arriving_;
  FrameQueue stream_;
  SceneView& view_;
  WindowDisplay& display_;

  std::map<uint32_t, StreamedObject> objects_;
  std::optional<ReceivedFrame> frame_;  // the newest
  Playout playout_;
  std::optional<OrbitCamera> camera_;
  FrameMeter meter_;
  MouseHands hands_;
  WindowStudy study_;
  WindowPicture picture_;
  ObjectPanel panel_{[this](const StreamedObject& object) { return rest_bounds(object); }};
  PartColours part_colours_;
  std::optional<SceneView::Picked> pointed_;  // kernel under the mouse
  WindowInput pointed_with_;                  // of the last picture
  bool was_left_ = false, panels_shown_ = true;
  bool asked_to_start_ = false;
  std::string author_selected_;  // as in the last picture
  SessionNotice notice_;
  std::string refusal_;
  int64_t begun_ns_ = 0;
  RestingCounters counters_;
  std::vector<Image> pictures_;  // before the first frame, and of a recording
  Image screenshot_, recorded_picture_;
  RunPanel shown_run_;  // in screenshot_
  int screenshots_ = 0;
};

Result<void> WindowRun::first_frame() {
  const Eigen::Vector2i size = display_.size_px();
  if (auto posed = view_.pose(*frame_->drivers); !posed) return posed;
  const auto free = columns_beside_panels(size.x(), false, display_.ui_scale());
  const auto camera =
      initial_camera(view_, {size.x(), size.y()}, options_.camera_file,
                     free ? std::optional(PictureColumns{free->first, free->second}) : std::nullopt);
  if (!camera) return camera.error();
  camera_.emplace(orbit_of(view_, *camera));
  if (!options_.poke.empty()) hands_.begin_script(options_.poke, camera->world_from_camera.position_m);
  if (!options_.select.empty() && !object_named(objects_, options_.select))
    return not_found("--select: no object is named \"" + options_.select +
                     "\"; start without --select to see the names");
  panel_.select(options_.select);
  begun_ns_ = now_ns();
  if (options_.forces.empty()) return {};
  return study_.record_at_start(options_.forces, objects_, window_camera());
}

Result<void> WindowRun::poll_updates() {
  auto update = stream_.take(view_);
  if (!update) return update.error();
  for (StreamedObject& object : update->described) {
    study_.follow(object);
    objects_[object.id] = std::move(object);
  }
  for (const uint32_t id : update->removed) {
    objects_.erase(id);
    panel_.forget_bounds(id);
  }
  for (const uint32_t id : update->refined) {
    study_.find_kernels_again(id);
    panel_.forget_bounds(id);
  }
  notice_.take(*update, client_);
  study_.take_frames();
  if (update->server_restarted) playout_.reset();
  if (update->frames.empty()) return {};
  frame_ = update->frames.back();
  for (ReceivedFrame& frame : update->frames) playout_.add(std::move(frame));
  return camera_ ? Result<void>() : first_frame();
}

void WindowRun::move_camera(const WindowInput& input) {
  const double height = display_.size_px().y();
  if (input.right) camera_->orbit(input.moved_px, height);
  if (input.middle) camera_->pan(input.moved_px, height);
  if (input.scrolled != 0) camera_->zoom(input.scrolled);
  camera_->fly(input.flown, input.passed_s);
}

// Picks the kernel under the mouse, and selects its object on a click. The pick stays valid while neither
// mouse nor scene move.
void WindowRun::point(const WindowInput& input, const Camera& window) {
  const WindowInput before = std::exchange(pointed_with_, input);
  if (picture_.drawn().empty() && input.mouse_px == before.mouse_px && input.left == before.left &&
      input.over_panel == before.over_panel)
    return;
  pointed_.reset();
  const bool pressed = input.left && !was_left_;
  was_left_ = input.left;
  if (input.over_panel || hands_.scripted() || (input.left && !pressed)) return;
  const Pose aim = ray_through(window, input.mouse_px);
  pointed_ = view_.pick(aim.position_m, aim.orientation * -Eigen::Vector3d::UnitZ());
  if (pointed_ && (pointed_->environment || !objects_.contains(pointed_->object_id))) pointed_.reset();
  if (!pressed || !pointed_) return;
  const std::string& name = objects_.at(pointed_->object_id).name;
  panel_.select(name);
  author_.select(name, input.ctrl);
  study_.aim({name, pointed_->object_id, pointed_->kernel, pointed_->rest_point_m});
}

void WindowRun::send_hands(const WindowInput& input) {
  if (!hands_.scripted())
    return hands_.send_mouse(input, window_camera(), input.left && !author_.uses_left_button(),
                             picture_.rests() && !holds() && !study_.records());
  const auto locate = [&](const std::string& name) -> std::optional<ObjectExtent> {
    for (const auto& [id, object] : objects_) {
      const Eigen::AlignedBox3d box = view_.bounds(id);
      if (object.name == name && !box.isEmpty()) return ObjectExtent{box.center(), box.sizes().maxCoeff()};
    }
    return std::nullopt;
  };
  hands_.send_script(seconds_from_ns(now_ns() - begun_ns_), locate);
}

// Applies the user's actions on the panels of the last picture and on the keyboard.
void WindowRun::act(const WindowInput& input) {
  const PanelActions& actions = display_.actions();
  if (frame_) author_.see(*frame_, objects_, view_);
  if (const auto& rgb = author_.scene().background_rgb(); rgb.size() == 3)
    view_.set_background(Eigen::Vector3d(rgb[0], rgb[1], rgb[2]).cast<float>());
  else
    view_.set_background(std::nullopt);
  author_.act(input, actions.scene, window_camera(), view_, *camera_);
  if (author_.selected() != author_selected_) panel_.select(author_selected_ = author_.selected());
  std::vector<ObjectCall> calls = panel_.act(actions, objects_);
  if (actions.selected) author_.select(panel_.selected(), false);
  for (ObjectCall& call : calls) {
    if (auto* set = std::get_if<SetPhysicsCall>(&call))
      calls_.set_physics(set->object, set->physics);
    else if (auto* restore = std::get_if<RestoreEstimateCall>(&call))
      calls_.restore_estimate(restore->object, restore->fields);
    else if (auto* accept = std::get_if<AcceptProposalCall>(&call))
      calls_.accept_proposal(accept->object, accept->decline);
    else if (auto* undo = std::get_if<UndoPhysicsCall>(&call))
      author_.available() ? author_.undo(undo->redo) : calls_.undo_physics(undo->object, undo->redo);
    else
      calls_.analyze(std::get<AnalyzeCall>(call).objects);
  }
  if (input.hide) panels_shown_ = !panels_shown_;
  act_on_run(input, actions);
  if (auto begun = study_.act(actions, window_camera()); !begun) refusal_ = begun.error().message;
}

// Pause, step, reset and the start of a simulation that waits for it.
void WindowRun::act_on_run(const WindowInput& input, const PanelActions& actions) {
  const bool paused = frame_ && frame_->run.paused();
  v1::ControlRunRequest request;
  // Without a user, the simulation starts with the first complete picture.
  const bool waiting = frame_ && frame_->run.waiting();
  const bool unattended = options_.seconds > 0 || !options_.poke.empty() || !options_.forces.empty();
  if (actions.start || (waiting && unattended && !asked_to_start_ && arriving_.progress().objects == 0)) {
    request.set_pause(false);
    asked_to_start_ = true;
  }
  if (waiting)
    begun_ns_ = now_ns();  // scripts and --seconds count from the start
  else
    asked_to_start_ = false;
  if (actions.pause || input.pause) request.set_pause(actions.pause.value_or(!paused));
  if (const int steps = input.step + (actions.step ? 1 : 0); steps > 0)
    request.set_step_ticks(static_cast<uint32_t>(steps));
  if (actions.reset) request.set_reset(true);
  if (request.action_case() != v1::ControlRunRequest::ACTION_NOT_SET) {
    refusal_.clear();
    calls_.control_run(request);
  }
}

Result<void> WindowRun::take_answers() {
  for (const ControlCalls::Answer& answer : calls_.take()) {
    const std::string why = answer.refused ? answer.refused->message : "";
    switch (answer.kind) {
      case ControlCalls::Answer::Kind::Physics:
        answer.physics ? panel_.take_reply(answer.object, *answer.physics)
                       : panel_.take_refusal(answer.object, why);
        break;
      case ControlCalls::Answer::Kind::Analysis:
        answer.progress ? panel_.take_progress(*answer.progress) : panel_.take_analysis_end(why);
        break;
      case ControlCalls::Answer::Kind::Run:
        refusal_ = why;
        break;
      case ControlCalls::Answer::Kind::Edit:
      case ControlCalls::Answer::Kind::Scene:
      case ControlCalls::Answer::Kind::Save:
      case ControlCalls::Answer::Kind::Assets:
      case ControlCalls::Answer::Kind::Preview:
        author_.take(answer);
        break;
      case ControlCalls::Answer::Kind::Force:
        refusal_ = why;
        if (auto taken = study_.take(answer); !taken) return taken;
        break;
    }
  }
  study_.request_forces();
  return {};
}

WindowPanels WindowRun::panels() const {
  WindowPanels panels;
  panels.shown = panels_shown_;
  const std::string notice = notice_.text(!refusal_.empty() ? refusal_ : frame_ ? frame_->run.message() : "");
  panels.run =
      run_panel({frame_ ? &*frame_ : nullptr, view_, picture_, meter_, arriving_.progress(), notice});
  panels.force = study_.panel();
  panels.objects = panel_.shown(objects_);
  panels.scene = author_.shown();
  return panels;
}

Eigen::AlignedBox3d WindowRun::rest_bounds(const StreamedObject& object) const {
  Eigen::AlignedBox3d bounds;
  if (const auto asset = view_.asset(object.id)) {
    for (const Eigen::Vector3f& at : asset->positions)
      bounds.extend(object.rest.object_from_asset * at.cast<double>());
  }
  return bounds;
}

// The boxes of the part that is edited, where the object is now.
void WindowRun::draw_part_boxes(const Camera& window, WindowOverlay& overlay) const {
  const std::vector<Eigen::AlignedBox3d> boxes = panel_.marked_boxes(objects_);
  const ReceivedFrame& shown = playout_.shown() ? *playout_.shown() : *frame_;
  for (const ObjectDrivers& drivers : shown.drivers->objects) {
    const auto object = objects_.find(drivers.object_id);
    if (boxes.empty() || object == objects_.end() || object->second.name != panel_.selected()) continue;
    const Pose pose = scene_pose(object->second.rest, drivers, 0);  // of the body's frame
    for (const Eigen::AlignedBox3d& box : boxes)
      add_box(window, box, pose, WindowLine::Ink::Part, overlay.lines);
  }
}

WindowOverlay WindowRun::overlay(const Camera& window) const {
  WindowOverlay overlay;
  overlay.panels = panels();
  if (!frame_) return overlay;
  author_.draw(window, view_, overlay);
  draw_part_boxes(window, overlay);
  const ReceivedFrame& shown = playout_.shown() ? *playout_.shown() : *frame_;
  study_.draw(shown, display_.input().over_panel, objects_, window, overlay);
  if (pointed_ && shown.hands.empty()) {
    if (const auto at = pixel_of(window, pointed_->point_m))
      overlay.aim = WindowAim{*at, objects_.at(pointed_->object_id).name};
  }
  return overlay;
}

Result<void> WindowRun::keep_screenshot() {
  const std::filesystem::path file = options_.screenshots / format_text("window_%03d.png", screenshots_++);
  note_written(file);
  if (screenshots_ == kManyScreenshots)
    log_warn("%s: %d screenshots so far; save fewer with --every N", options_.screenshots.c_str(),
             screenshots_);
  return write_png(file, screenshot_);
}

// Whether a hand holds something, or a script moves it.
bool WindowRun::holds() const {
  return hands_.scripted() || (playout_.shown() && !playout_.shown()->hands.empty());
}

// Time for which the window may wait for events and messages.
double WindowRun::wait_s() const {
  double wait_s = picture_.wait_s(now_ns());
  if (holds() || !playout_.settled() || stream_.binds() || study_.records())
    wait_s = std::min(wait_s, StillPicture::kAlertWait_s);
  if (options_.on_picture || !options_.screenshots.empty()) wait_s = std::min(wait_s, kWatchedWait_s);
  return wait_s;
}

// Draws a picture of the live scene.
Result<void> WindowRun::picture() {
  const WindowInput& input = display_.input();
  const Eigen::Vector2i size = display_.size_px();
  move_camera(input);
  send_hands(input);
  const int64_t now = now_ns();
  if (auto posed = view_.pose(*playout_.at(now, now)); !posed) return posed;
  const Camera window = camera_->camera(size.x(), size.y());
  if (auto drawn = picture_.draw(view_, *camera_, size, now); !drawn) return drawn;
  point(input, window);
  act(input);
  part_colours_.show(panel_.in_part_colours(objects_), view_);
  WindowOverlay over = overlay(window);
  counters_.hold(over.panels.run, picture_.rests());
  if (options_.on_picture) shown_run_ = over.panels.run;
  display_.set_overlay(std::move(over));
  return {};
}

// Draws the next picture of the recording's video, without panels.
Result<void> WindowRun::recorded_picture(const PlannedFrame& planned) {
  picture_.reset();
  view_.set_min_contribution(0);
  if (auto drawn = view_.draw(*study_.next(), planned.views, pictures_); !drawn) return drawn;
  display_.set_overlay(study_.recorded_overlay(objects_, window_camera()));
  display_.keep_next(recorded_picture_);
  return {};
}

Result<void> WindowRun::run(const std::atomic<bool>& interrupted) {
  auto shown = show(interrupted);
  if (!study_.records()) return shown;
  auto cut = study_.cut(!shown        ? shown.error().message
                        : interrupted ? "interrupted"
                                      : "the window was closed");
  return shown ? cut : shown;
}

Result<void> WindowRun::show(const std::atomic<bool>& interrupted) {
  client_.start(stream_);
  begun_ns_ = now_ns();
  int64_t second_ns = now_ns(), last_ns = now_ns();
  while (!interrupted) {
    if (auto taken = poll_updates(); !taken) return taken;
    if (auto taken = take_answers(); !taken) return taken;
    bool records = study_.draws();
    if (camera_) display_.set_camera(window_camera());
    display_.set_wait(records ? 0 : wait_s());
    const auto planned = display_.wait_frame();
    if (!planned) break;
    if (picture_.rests()) last_ns = now_ns();  // a wait for events does not count as the time of a picture
    Result<void> drawn;
    if (!camera_) {
      pictures_.assign(1, Image{1, 1, {0.08f, 0.08f, 0.1f, 1.0f}});
      display_.set_overlay(overlay({}));
    } else {
      if (records) {
        drawn = recorded_picture(*planned);
        if (!drawn && ends_with_recording()) return drawn;
        // An object fractured meanwhile has other bodies than the recorded frames.
        if (!drawn) {
          if (auto finished = study_.finish(); !finished) return finished;
          refusal_ = "recording incomplete: " + drawn.error().message;
          log_warn("%s", refusal_.c_str());
          records = false;
        }
      }
      if (!records) drawn = picture();
    }
    if (!drawn) return drawn;
    const bool second_is_over = now_ns() - second_ns >= 1'000'000'000;
    const bool due =
        options_.screenshot_every > 0 ? planned->index % options_.screenshot_every == 0 : second_is_over;
    const bool keeps = due && !options_.screenshots.empty() && camera_ && !records;
    const bool looked_at = options_.on_picture && camera_ && !records;
    if (keeps || looked_at) display_.keep_next(screenshot_);
    const std::span<const Image> shown = camera_ && !records ? picture_.drawn() : pictures_;
    if (auto submitted = display_.submit(*planned, shown); !submitted) return submitted;
    const int64_t now = now_ns();
    if (playout_.shown() && !records && !shown.empty())
      meter_.shown(*playout_.shown(), now, milliseconds_from_ns(now - last_ns), view_.last_times().device);
    last_ns = now;
    if (second_is_over) second_ns = now;
    if (keeps) {
      if (auto kept = keep_screenshot(); !kept) return kept;
    }
    if (looked_at) options_.on_picture(screenshot_, shown_run_);
    if (records) {
      const auto last = study_.keep(recorded_picture_);
      if (!last) return last.error();
      if (*last && ends_with_recording()) break;
    }
    // Counted from the first frame, if one is expected.
    const bool counts = options_.seconds > 0 && (camera_ || client_.ended() ||
                                                 seconds_from_ns(now - begun_ns_) >= kFirstFrameTimeout_s);
    if (counts && seconds_from_ns(now - begun_ns_) >= options_.seconds) break;
  }
  return {};
}

}  // namespace

Result<void> run_window(const WindowRunOptions& options, const std::atomic<bool>& interrupted) {
  if (!options.screenshots.empty()) {
    std::error_code error;
    std::filesystem::create_directories(options.screenshots, error);
    if (error)
      return invalid_argument(options.screenshots.string() + ": cannot be created: " + error.message() +
                              "; choose another folder with --output");
  }
  const PictureSize size = options.size.value_or(PictureSize{1280, 800});
  auto display = WindowDisplay::open("LiveGS " + options.address, size.width, size.height, options.ui_scale,
                                     !options.size);
  if (!display) return display.error();
  JoinOptions join = options;
  join.starts_run = true;
  join.coarse_first = options.forces.empty();  // a recording that starts at once shows complete objects
  SceneLoader loading(std::move(join), [&] { return choose_renderer(options.renderer); });
  auto live = load_in_window(loading, **display, interrupted);
  if (!live) return live.error();
  if (!*live) return {};
  SceneControl control((*live)->client->place());
  WindowRun run(options, *(*live)->client, control, (*live)->objects, (*live)->view, **display);
  const auto done = run.run(interrupted);
  (*live)->stop.request_stop();  // running fetches are not needed any more
  const auto stopped =
      (*live)->client->stop();  // before the run's stream is destroyed, which the reader calls
  if (!stopped) log_warn("%s", stopped.error().message.c_str());
  return done;
}

}  // namespace livegs
