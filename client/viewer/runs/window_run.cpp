// SPDX-License-Identifier: Apache-2.0
#include "viewer/runs/window_run.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <utility>

#include "core/clock.h"
#include "core/format_text.h"
#include "core/log.h"
#include "core/written_files.h"
#include "stream/session/scene_control.h"
#include "stream/session/scripted_hands.h"
#include "stream/session/session_client.h"
#include "viewer/author/author_run.h"
#include "viewer/camera/client_view_cone.h"
#include "viewer/camera/initial_camera.h"
#include "viewer/camera/orbit_camera.h"
#include "viewer/camera/window_picture.h"
#include "viewer/hands/force_arrow.h"
#include "viewer/live/control_calls.h"
#include "viewer/live/frame_queue.h"
#include "viewer/live/playout.h"
#include "viewer/live/session_notice.h"
#include "viewer/panels/frame_meter.h"
#include "viewer/panels/object_panel.h"
#include "viewer/runs/loading_window.h"
#include "viewer/study/force_study.h"
#include "viewer/study/study_recording.h"
#include "xr/window/draw_panels.h"
#include "xr/window_display.h"

namespace livegs {
namespace {

constexpr size_t kRightHand = 1;
constexpr int kManyScreenshots = 100;  // are worth a warning; they take some 60 MB
// Longest wait while pictures are taken, by a test or for screenshots.
constexpr double kWatchedWait_s = 0.05;
constexpr const char* kHelp =
    "left: pull   right: rotate   middle: pan\nwheel: zoom   WASDQE: fly   space: shoot\n"
    "P: pause   full stop: step   H: hide panels\n1 to 5: pull, move, turn, scale, measure   F: frame";

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
  void hold_counters(RunPanel& run);
  bool holds() const;
  void send_hands(const WindowInput& input);
  void send_script();
  void act(const WindowInput& input);
  Result<ForceStudy> study_of(const v1::Event::Force& force) const;
  Result<void> begin_recording(std::vector<ForceStudy> studies);
  Result<void> finish_recording();
  bool ends_with_recording() const { return !options_.forces.empty() && options_.seconds == 0; }
  void abandon_recording();
  Result<void> cut_recording(const std::string& why);
  Result<void> take_answers();
  Result<void> picture();
  Result<void> recorded_picture(const PlannedFrame& planned);
  void draw_force(const Eigen::Vector3d& point_m, const Eigen::Vector3d& force_n, uint32_t object_id,
                  const Camera& window, WindowOverlay& overlay) const;
  void draw_study(const ForceStudy& study, const Camera& window, WindowOverlay& overlay) const;
  WindowOverlay overlay(const Camera& window) const;
  WindowPanels panels() const;
  Result<void> keep_screenshot();
  const StreamedObject* named(const std::string& name) const;

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
  std::optional<ScriptedHands> script_;
  InputSample sample_;
  HandSample sent_hand_;  // of the last sample
  WindowPicture picture_;
  FrameMeter meter_;
  ObjectPanel panel_;
  ForceStudy study_;
  std::optional<StudyRecording> recording_;
  bool records_options_ = false;              // recording_ holds the forces given at the start
  std::string recorded_;                      // path of the last recording
  std::optional<SceneView::Picked> pointed_;  // kernel under the mouse
  WindowInput pointed_with_;                  // of the last picture
  bool was_left_ = false, panels_shown_ = true;
  bool asked_to_start_ = false;
  std::string author_selected_;    // as in the last picture
  uint64_t force_until_tick_ = 0;  // for the force of the panel
  SessionNotice notice_;
  std::string refusal_;
  int64_t begun_ns_ = 0;
  RunPanel counted_;             // with the counters that are shown at rest
  bool rested_ = false;          // counted_ is of a picture at rest
  std::vector<Image> pictures_;  // before the first frame, and of a recording
  Image screenshot_, recorded_picture_;
  RunPanel shown_run_;  // in screenshot_
  int screenshots_ = 0;
};

bool same(const HandSample& a, const HandSample& b) {
  return a.active == b.active && a.trigger == b.trigger && a.aim.position_m == b.aim.position_m &&
         a.aim.orientation.coeffs() == b.aim.orientation.coeffs();
}

const StreamedObject* WindowRun::named(const std::string& name) const {
  for (const auto& [id, object] : objects_) {
    if (object.name == name && !object.environment) return &object;
  }
  return nullptr;
}

Result<void> WindowRun::first_frame() {
  const Eigen::Vector2i size = display_.size_px();
  if (auto posed = view_.pose(*frame_->drivers); !posed) return posed;
  const auto free = columns_beside_panels(size.x(), false, display_.ui_scale());
  const auto camera =
      initial_camera(view_, {size.x(), size.y()}, options_.camera_file,
                     free ? std::optional(PictureColumns{free->first, free->second}) : std::nullopt);
  if (!camera) return camera.error();
  camera_.emplace(orbit_of(view_, *camera));
  const Eigen::Vector3d eye = camera->world_from_camera.position_m;
  if (!options_.poke.empty())
    script_.emplace(poke_script(options_.poke), ScriptedHands::Settings{eye, client_.scene().ball_speed_m_s});
  if (!options_.select.empty() && !named(options_.select))
    return not_found("--select: no object is named \"" + options_.select + "\"");
  panel_.select(options_.select);
  begun_ns_ = now_ns();
  if (options_.forces.empty()) return {};
  std::vector<ForceStudy> studies;
  for (const v1::Event::Force& force : options_.forces) {
    auto study = study_of(force);
    if (!study) return study.error();
    studies.push_back(*std::move(study));
  }
  study_ = studies.back();
  records_options_ = true;
  return begin_recording(std::move(studies));
}

Result<ForceStudy> WindowRun::study_of(const v1::Event::Force& force) const {
  const StreamedObject* object = named(force.object());
  const Eigen::Vector3d rest_point_m(force.point_m(0), force.point_m(1), force.point_m(2));
  const auto kernel = object ? view_.nearest_kernel(object->id, rest_point_m) : std::nullopt;
  if (!kernel) return not_found("--force: no object is named \"" + force.object() + "\"");
  ForceStudy study;
  study.aim({force.object(), object->id, *kernel, rest_point_m});
  study.choose_force({force.force_n(0), force.force_n(1), force.force_n(2)}, force.duration_s());
  return study;
}

Result<void> WindowRun::poll_updates() {
  auto update = stream_.take(view_);
  if (!update) return update.error();
  for (StreamedObject& object : update->described) {
    study_.follow(object.name, object.id);
    objects_[object.id] = std::move(object);
  }
  for (const uint32_t id : update->removed) objects_.erase(id);
  for (const uint32_t id : update->refined) {
    study_.find_kernel_again(id, view_);
    if (recording_) recording_->find_kernels_again(id, view_);
  }
  notice_.take(*update, client_);
  if (recording_) {
    for (const ReceivedFrame& frame : stream_.take_recorded()) recording_->add(frame);
    stream_.record_frames(recording_->collecting());
  }
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

// Picks the kernel under the mouse, and selects its object on a click. What was picked stays while neither
// mouse nor scene move.
void WindowRun::point(const WindowInput& input, const Camera& window) {
  const WindowInput before = std::exchange(pointed_with_, input);
  if (picture_.drawn().empty() && input.mouse_px == before.mouse_px && input.left == before.left &&
      input.over_panel == before.over_panel)
    return;
  pointed_.reset();
  const bool pressed = input.left && !was_left_;
  was_left_ = input.left;
  if (input.over_panel || script_ || (input.left && !pressed)) return;
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
  const Eigen::Vector2i size = display_.size_px();
  HandSample& hand = sample_.hands[kRightHand];
  hand.active = true;
  const Camera window = camera_->camera(size.x(), size.y());
  client_.set_view(client_view_cone(std::span(&window, 1)));
  hand.aim = ray_through(window, input.mouse_px);
  hand.grip = hand.aim;
  hand.trigger = input.left && !author_.uses_left_button() ? 1.0f : 0.0f;
  const auto send = [&](bool shoot) {
    hand.shoot = shoot;
    ++sample_.sequence;
    sample_.sampled_ns = now_ns();
    meter_.sampled(sample_.sequence, sample_.sampled_ns);
    client_.send(sample_);
  };
  for (int press = 0; press < input.shoot; ++press) {  // one rising edge each
    send(true);
    send(false);
  }
  // At rest a repeated sample would only wake the server, and its reply this window.
  const bool repeats = picture_.rests() && !holds() && hand.trigger == 0 && same(hand, sent_hand_);
  if (input.shoot == 0 && !repeats) send(false);
  sent_hand_ = hand;
}

void WindowRun::send_script() {
  const auto locate = [&](const std::string& name) -> std::optional<ObjectExtent> {
    for (const auto& [id, object] : objects_) {
      const Eigen::AlignedBox3d box = view_.bounds(id);
      if (object.name == name && !box.isEmpty()) return ObjectExtent{box.center(), box.sizes().maxCoeff()};
    }
    return std::nullopt;
  };
  const InputSample sample = script_->at(seconds_from_ns(now_ns() - begun_ns_), locate);
  meter_.sampled(sample.sequence, now_ns());
  client_.send(sample);
}

Result<void> WindowRun::begin_recording(std::vector<ForceStudy> studies) {
  const Eigen::Vector2i size = display_.size_px();
  const std::filesystem::path folder = options_.screenshots.empty() ? "out/study" : options_.screenshots;
  auto begun = StudyRecording::begin(folder, std::move(studies), camera_->camera(size.x(), size.y()),
                                     client_.scene().rate_hz);
  if (!begun) return begun.error();
  recording_.emplace(std::move(*begun));
  stream_.record_frames(true);
  return {};
}

Result<void> WindowRun::finish_recording() {
  auto finished = recording_->finish();
  const std::filesystem::path video = recording_->video_path();
  recording_.reset();
  records_options_ = false;
  if (finished && std::filesystem::exists(video)) {  // not if its first picture failed
    recorded_ = video;
    log_info("recording saved: %s", recorded_.c_str());
  }
  return finished;
}

void WindowRun::abandon_recording() {
  if (!recording_) return;
  recording_->abandon();
  recording_.reset();
  stream_.record_frames(false);
}

// Ends the recording early.
Result<void> WindowRun::cut_recording(const std::string& why) {
  const bool asked_for = records_options_;
  std::string left;
  if (recording_->any_drawn()) {
    const std::string drawn = recording_->drawn(), file = recording_->video_path();
    auto finished = finish_recording();
    if (!finished) return finished;
    left = why + ": " + file + " is incomplete: " + drawn;
  } else {
    abandon_recording();
    left = why + " before the first picture of the recording; no video was written";
  }
  if (asked_for) return Error{ErrorCode::Unavailable, "--force: " + left};
  log_warn("%s", left.c_str());
  return {};
}

// Applies the user's actions on the panels of the last picture and on the keyboard.
void WindowRun::act(const WindowInput& input) {
  const PanelActions& actions = display_.actions();
  if (frame_) author_.see(*frame_, objects_, view_);
  if (const auto& rgb = author_.scene().background_rgb(); rgb.size() == 3)
    view_.set_background(Eigen::Vector3d(rgb[0], rgb[1], rgb[2]).cast<float>());
  else
    view_.set_background(std::nullopt);
  const Eigen::Vector2i size = display_.size_px();
  author_.act(input, actions.scene, camera_->camera(size.x(), size.y()), view_, *camera_);
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
  if (actions.force) study_.choose(*actions.force);
  if (actions.apply_force && study_.target()) calls_.apply_force(study_.message());
  if (actions.record_force && study_.target() && !recording_) {
    if (auto begun = begin_recording({study_}); !begun) refusal_ = begun.error().message;
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
        if (answer.refused) {
          abandon_recording();
          // Without a user to choose another force, the requested recording has failed, whatever the reason.
          if (records_options_) return Error{ErrorCode::Unavailable, "--force: " + why};
          break;
        }
        force_until_tick_ =
            answer.tick + static_cast<uint64_t>(study_.duration_s() * client_.scene().rate_hz);
        if (recording_) recording_->force_taken(answer.tick);
        break;
    }
  }
  if (recording_ && recording_->wants_force()) {
    for (const ForceStudy& study : recording_->studies()) calls_.apply_force(study.message());
  }
  return {};
}

void WindowRun::draw_force(const Eigen::Vector3d& point_m, const Eigen::Vector3d& force_n, uint32_t object_id,
                           const Camera& window, WindowOverlay& overlay) const {
  const auto held = pixel_of(window, point_m);
  if (!held) return;
  const auto object = objects_.find(object_id);
  const Eigen::AlignedBox3d box = view_.bounds(object_id);
  const double scale = arrow_metres_per_newton(object == objects_.end() ? 0.0 : object->second.mass_kg,
                                               box.isEmpty() ? 0.0 : box.sizes().maxCoeff());
  const auto seen = project_arrow(window, point_m, force_n, scale);
  overlay.arrows.push_back({*held, seen ? std::optional(seen->outline_px) : std::nullopt,
                            quantity_text(force_n.norm(), Unit::Newton)});
}

void WindowRun::draw_study(const ForceStudy& study, const Camera& window, WindowOverlay& overlay) const {
  if (!study.target()) return;
  const auto point_m = view_.kernel_position_m(study.target()->object_id, study.target()->kernel);
  if (point_m) draw_force(*point_m, study.force_n(), study.target()->object_id, window, overlay);
}

WindowPanels WindowRun::panels() const {
  WindowPanels panels;
  panels.shown = panels_shown_;
  RunPanel& run = panels.run;
  run.paused = frame_ && frame_->run.paused();
  run.loading = frame_ && frame_->run.loading();
  run.waiting = frame_ && frame_->run.waiting();
  run.notice = notice_.text(!refusal_.empty() ? refusal_ : frame_ ? frame_->run.message() : "");
  if (run.notice.empty()) run.notice = view_.notice();
  run.lines.push_back(view_.renderer_name());
  run.lines.push_back(picture_.text());
  // The same number of lines at rest, so that nothing moves under the mouse.
  run.lines.push_back(picture_.rests() ? "no new pictures"
                                       : format_text("%.0f fps, %.0f server ticks/s",
                                                     meter_.pictures_a_second(), meter_.ticks_a_second()));
  if (frame_) {
    run.lines.push_back(format_text("tick %llu, %.1f s simulated%s",
                                    static_cast<unsigned long long>(frame_->tick), frame_->run.simulated_s(),
                                    run.paused         ? ", paused"
                                    : picture_.rests() ? " at rest"
                                                       : ""));
  }
  if (const auto coming = arriving_.progress(); coming.objects > 0) {
    // On the renderer's line, so that the panel keeps its height.
    run.lines.front() += format_text(", loading %zu objects: %.0f %%", coming.objects,
                                     100.0 * static_cast<double>(coming.kernels_shown) /
                                         static_cast<double>(std::max<uint64_t>(coming.kernels_total, 1)));
  }
  run.graph = meter_.graph();
  if (const auto latency_ms = meter_.hand_to_picture_ms()) {
    run.latency = format_text("input latency %.0f ms\nskin %.1f ms, render %.1f ms", *latency_ms,
                              view_.last_times().skin_ms, view_.last_times().raster_ms);
  }
  if (const auto& device = view_.last_times().device) {
    run.latency += format_text("%sdevice: skin %.1f, project %.1f, sort %.1f, draw %.1f, resolve %.1f ms",
                               run.latency.empty() ? "" : "\n", device->skin_ms, device->project_ms,
                               device->sort_ms, device->draw_ms, device->resolve_ms);
  }
  run.help = kHelp;
  panels.force = study_.shown(recording_ ? recording_->progress() : std::string());
  if (!recording_ && !recorded_.empty()) panels.force.sentence += " Recorded: " + recorded_;
  panels.objects = panel_.shown(objects_);
  panels.scene = author_.shown();
  return panels;
}

WindowOverlay WindowRun::overlay(const Camera& window) const {
  WindowOverlay overlay;
  overlay.panels = panels();
  if (!frame_) return overlay;
  author_.draw(window, view_, overlay);
  const ReceivedFrame& shown = playout_.shown() ? *playout_.shown() : *frame_;
  for (const HeldByHand& held : shown.hands) {
    draw_force(held.point_m.cast<double>(), held.force_n.cast<double>(), held.object_id, window, overlay);
  }
  const bool acts = shown.tick <= force_until_tick_;
  const std::vector<ForceStudy> studies = recording_ ? recording_->studies() : std::vector{study_};
  if (acts || (display_.input().over_panel && shown.hands.empty())) {
    for (const ForceStudy& study : studies) draw_study(study, window, overlay);
  }
  if (acts || recording_) overlay.sentence = sentence_of(studies);
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
    log_warn("%s: %d screenshots so far; fewer with --every N", options_.screenshots.c_str(), screenshots_);
  return write_png(file, screenshot_);
}

// At rest, counters alone do not redraw the window.
void WindowRun::hold_counters(RunPanel& run) {
  if (rested_ && picture_.rests() && counted_.paused == run.paused) {
    run.lines = counted_.lines;
    run.latency = counted_.latency;
  }
  rested_ = picture_.rests();
  counted_ = run;
}

// Whether a hand holds something, or a script moves it.
bool WindowRun::holds() const { return script_ || (playout_.shown() && !playout_.shown()->hands.empty()); }

// Time for which the window may wait for events and messages.
double WindowRun::wait_s() const {
  double wait_s = picture_.wait_s(now_ns());
  if (holds() || !playout_.settled() || stream_.binds())
    wait_s = std::min(wait_s, StillPicture::kAlertWait_s);
  if (options_.on_picture || !options_.screenshots.empty()) wait_s = std::min(wait_s, kWatchedWait_s);
  return wait_s;
}

// Draws a picture of the live scene.
Result<void> WindowRun::picture() {
  const WindowInput& input = display_.input();
  const Eigen::Vector2i size = display_.size_px();
  move_camera(input);
  script_ ? send_script() : send_hands(input);
  const int64_t now = now_ns();
  if (auto posed = view_.pose(*playout_.at(now, now)); !posed) return posed;
  const Camera window = camera_->camera(size.x(), size.y());
  if (auto drawn = picture_.draw(view_, *camera_, size, now); !drawn) return drawn;
  point(input, window);
  act(input);
  WindowOverlay over = overlay(window);
  hold_counters(over.panels.run);
  if (options_.on_picture) shown_run_ = over.panels.run;
  display_.set_overlay(std::move(over));
  return {};
}

// Draws the next picture of the recording's video, without panels.
Result<void> WindowRun::recorded_picture(const PlannedFrame& planned) {
  const Eigen::Vector2i size = display_.size_px();
  picture_.reset();
  view_.set_min_contribution(0);
  if (auto drawn = view_.draw(*recording_->next(), planned.views, pictures_); !drawn) return drawn;
  WindowOverlay overlay;
  overlay.panels.shown = false;
  overlay.sentence = recording_->sentence();
  const Camera window = camera_->camera(size.x(), size.y());
  for (size_t i = 0; i < recording_->studies().size(); ++i) {
    if (recording_->acts(i)) draw_study(recording_->studies()[i], window, overlay);
  }
  display_.set_overlay(std::move(overlay));
  display_.keep_next(recorded_picture_);
  return {};
}

Result<void> WindowRun::run(const std::atomic<bool>& interrupted) {
  auto shown = show(interrupted);
  if (!recording_) return shown;
  auto cut = cut_recording(!shown        ? shown.error().message
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
    bool records = recording_ && recording_->next();
    const Eigen::Vector2i size = display_.size_px();
    if (camera_) display_.set_camera(camera_->camera(size.x(), size.y()));
    display_.set_wait(records ? 0 : wait_s());
    const auto planned = display_.wait_frame();
    if (!planned) break;
    if (picture_.rests()) last_ns = now_ns();  // a wait for events is no time of a picture
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
          if (auto finished = finish_recording(); !finished) return finished;
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
      if (auto kept = recording_->keep(recorded_picture_); !kept) return kept;
      if (!recording_->next()) {
        if (auto finished = finish_recording(); !finished) return finished;
        if (ends_with_recording()) break;
      }
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
      return invalid_argument(options.screenshots.string() + ": cannot be created: " + error.message());
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
  SceneControl control(options.address, options.access);
  WindowRun run(options, *(*live)->client, control, (*live)->objects, (*live)->view, **display);
  const auto done = run.run(interrupted);
  (*live)->stop.request_stop();  // running fetches are not needed any more
  const auto stopped =
      (*live)->client->stop();  // before the run's stream is destroyed, which the reader calls
  if (!stopped) log_warn("%s", stopped.error().message.c_str());
  return done;
}

}  // namespace livegs
