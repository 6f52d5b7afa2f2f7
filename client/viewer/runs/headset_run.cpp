// SPDX-License-Identifier: Apache-2.0
#include "viewer/runs/headset_run.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/clock.h"
#include "core/log.h"
#include "core/percentile.h"
#include "core/text/format_text.h"
#include "splat/camera_file.h"
#include "stream/session/session_client.h"
#include "viewer/camera/client_view_cone.h"
#include "viewer/camera/initial_camera.h"
#include "viewer/camera/render_scale.h"
#include "viewer/hands/force_arrow.h"
#include "viewer/hands/hand_markers.h"
#include "viewer/hands/haptics.h"
#include "viewer/hands/touch_prediction.h"
#include "viewer/live/frame_queue.h"
#include "viewer/live/playout.h"
#include "viewer/live/scene_loader.h"
#include "viewer/live/session_notice.h"
#include "viewer/output/frame_log.h"
#include "viewer/panels/frame_meter.h"

namespace livegs {
namespace {

constexpr double kDrawBudgetShare = 0.8;  // share of the picture interval for drawing
constexpr size_t kMaxLatencies = 1 << 20;

class HeadsetRun {
 public:
  HeadsetRun(const HeadsetRunOptions& options, SessionClient& client, ProgressiveObjects& arriving,
             SceneView& view, HeadsetDisplay& display)
      : options_(options), client_(client), stream_(arriving), view_(view), display_(display) {
    for (const StreamedObject& object : client.scene().objects) masses_kg_[object.id] = object.mass_kg;
    stream_.hide(client.scene().objects);
  }

  Result<void> run(const std::atomic<bool>& interrupted);
  HeadsetRunSummary summary() const;

 private:
  Result<void> poll_updates();
  Result<void> place();
  void send_hands(int64_t displayed_ns);
  void send_hands_again(int64_t displayed_ns);
  void vibrate(size_t hand, const std::optional<Haptics::Pulse>& pulse);
  void feel(const ReceivedFrame& frame);
  void foresee(int64_t displayed_ns);
  double size_when_taken_m(uint32_t object_id);
  void add_marks(DriverFrame& drivers);
  Result<void> draw(PlannedFrame& planned);

  const HeadsetRunOptions& options_;
  SessionClient& client_;
  FrameQueue stream_;
  SceneView& view_;
  HeadsetDisplay& display_;

  Playout playout_;
  std::map<uint32_t, double> masses_kg_;  // by object id, like the next
  std::map<uint32_t, double> sizes_m_;    // of objects that a hand has grabbed
  bool placed_ = false;
  int64_t placed_ns_ = 0;
  InputSample sample_;
  Haptics feel_;
  TouchPrediction touch_;
  FrameMeter meter_;
  uint64_t measured_sequence_ = 0;
  std::vector<double> latencies_ms_, draws_ms_;
  size_t vibrations_ = 0;
  std::vector<Image> images_;
  int64_t last_ns_ = 0;
  SessionNotice notice_;
  std::string run_message_;  // the server's message about its run
  double scale_budget_ms_ = 0;
  std::optional<RenderScale> scale_;
};

// Places the user where the camera would be, upright.
Result<void> HeadsetRun::place() {
  constexpr PictureSize kDefaultViewSize{640, 640};
  const auto first = initial_camera(view_, kDefaultViewSize, options_.camera_file);
  if (!first) return first.error();
  const Camera& camera = *first;
  const Eigen::Vector3d ahead = camera.world_from_camera.orientation * -Eigen::Vector3d::UnitZ();
  const double turn_rad = std::hypot(ahead.x(), ahead.z()) > 1e-6 ? std::atan2(-ahead.x(), -ahead.z()) : 0.0;
  display_.set_scene_from_local({camera.world_from_camera.position_m,
                                 Eigen::Quaterniond(Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitY()))});
  if (options_.marks) {
    if (auto added = HandMarkers::add_to(view_); !added) return added;
  }
  placed_ = true;
  placed_ns_ = now_ns();
  return {};
}

Result<void> HeadsetRun::poll_updates() {
  auto update = stream_.take(view_);
  if (!update) return update.error();
  for (const StreamedObject& object : update->described) {
    masses_kg_[object.id] = object.mass_kg;
    sizes_m_.erase(object.id);
  }
  for (const uint32_t id : update->refined) sizes_m_.erase(id);
  notice_.take(*update, client_);
  if (update->server_restarted) playout_.reset();
  if (update->frames.empty()) return {};
  const auto newest = update->frames.back().drivers;
  run_message_ = update->frames.back().run.message();
  for (ReceivedFrame& frame : update->frames) {
    feel(frame);
    playout_.add(std::move(frame));
  }
  if (placed_) return {};
  if (auto posed = view_.pose(*newest); !posed) return posed;
  return place();
}

void HeadsetRun::send_hands(int64_t displayed_ns) {
  const HeadsetInput& input = display_.input();
  sample_.hands = input.hands;
  ++sample_.sequence;
  sample_.sampled_ns = displayed_ns;  // when the pose is predicted for
  meter_.sampled(sample_.sequence, now_ns());
  client_.send(sample_);
}

// Sampling once per picture delays a hand motion by half a picture on average and by a whole one at worst. So
// the hands are sampled again after each long step.
void HeadsetRun::send_hands_again(int64_t displayed_ns) {
  if (display_.update_input()) send_hands(displayed_ns);
}

void HeadsetRun::vibrate(size_t hand, const std::optional<Haptics::Pulse>& pulse) {
  if (!pulse) return;
  display_.vibrate(hand, pulse->amplitude, pulse->seconds);
  ++vibrations_;
}

// Haptics from server data: held objects and their contact impulses.
void HeadsetRun::feel(const ReceivedFrame& frame) {
  std::array<uint32_t, 2> held{};
  for (const HeldByHand& one : frame.hands) {
    if (one.hand < held.size()) held[one.hand] = one.object_id;
  }
  for (size_t hand = 0; hand < held.size(); ++hand) vibrate(hand, feel_.holds(hand, held[hand]));
  for (const HeldByHand& one : frame.hands) {
    if (one.hand < held.size())
      vibrate(one.hand, feel_.reported(one.hand, one.contact_impulse_n_s, frame.received_ns));
  }
}

// Haptics from predicted contacts. An object on a ray does not move with the hand.
void HeadsetRun::foresee(int64_t displayed_ns) {
  const auto& hands = display_.input().hands;
  for (size_t hand = 0; hand < hands.size(); ++hand) {
    uint32_t in_grip = 0;
    bool on_ray = false;
    for (const HeldByHand& one : playout_.shown()->hands) {
      if (one.hand == hand) (one.grabbed ? in_grip = one.object_id : on_ray = true);
    }
    const auto touch = on_ray ? std::nullopt : touch_.at(hand, hands[hand], in_grip, view_, displayed_ns);
    if (touch)
      vibrate(hand, feel_.foreseen(hand, touch->touches, touch->speed_m_s, now_ns()));
    else
      feel_.on_no_prediction(hand);
  }
}

// Size at the time of the grab: computing it from all kernels costs more than a picture.
double HeadsetRun::size_when_taken_m(uint32_t object_id) {
  const auto [known, fresh] = sizes_m_.try_emplace(object_id, 0.0);
  if (fresh) {
    const Eigen::AlignedBox3d box = view_.bounds(object_id);
    if (!box.isEmpty()) known->second = box.sizes().maxCoeff();
  }
  return known->second;
}

void HeadsetRun::add_marks(DriverFrame& drivers) {
  std::vector<HandMarkers::Force> forces;
  for (const HeldByHand& held : playout_.shown()->hands) {
    const auto mass = masses_kg_.find(held.object_id);
    const double size_m = size_when_taken_m(held.object_id);
    if (mass == masses_kg_.end() || size_m <= 0) continue;
    const double metres_a_newton = arrow_metres_per_newton(mass->second, size_m);
    forces.push_back({held.hand, held.point_m.cast<double>(), metres_a_newton * held.force_n.cast<double>()});
  }
  HandMarkers::append(display_.input().hands, forces, drivers);
}

Result<void> HeadsetRun::draw(PlannedFrame& planned) {
  const int64_t begun_ns = now_ns();
  auto drivers = playout_.at(begun_ns, planned.display_time_ns);
  if (!drivers) return display_.submit(planned, {});
  if (options_.marks) add_marks(*drivers);
  if (auto posed = view_.prepare(*drivers); !posed) return posed;
  foresee(planned.display_time_ns);
  send_hands_again(planned.display_time_ns);
  display_.update_views(planned);  // skinning took time, and the head has moved
  client_.set_view(client_view_cone(planned.views));
  const auto image = display_.acquire();
  if (!image) return display_.submit(planned, {});
  if (auto drawn = view_.draw_into(*drivers, planned.views, *image, images_); !drawn) {
    planned.views.clear();  // the frame was begun and ends without a picture
    (void)display_.submit(planned, {});
    return drawn;
  }
  const int64_t drawn_ns = now_ns();
  send_hands_again(planned.display_time_ns);
  const uint64_t before = display_.counts().pictures;
  if (auto submitted = display_.submit(planned, images_); !submitted) return submitted;
  if (display_.counts().pictures == before) return {};  // the session was lost meanwhile
  if (options_.on_picture) options_.on_picture(planned, view_);
  if (draws_ms_.size() < kMaxLatencies) draws_ms_.push_back(milliseconds_from_ns(drawn_ns - begun_ns));
  // For the first picture of each sample.
  const ReceivedFrame& shown = *playout_.shown();
  meter_.shown(shown, std::max(drawn_ns, planned.display_time_ns), milliseconds_from_ns(drawn_ns - last_ns_));
  last_ns_ = drawn_ns;
  if (shown.input_sequence > measured_sequence_ && meter_.hand_to_picture_ms() &&
      latencies_ms_.size() < kMaxLatencies) {
    measured_sequence_ = shown.input_sequence;
    latencies_ms_.push_back(*meter_.hand_to_picture_ms());
  }
  if (!options_.scales) return {};
  const double budget_ms = 1e3 * kDrawBudgetShare * display_.period_s();
  if (!scale_ || std::abs(budget_ms - scale_budget_ms_) > 0.01) scale_.emplace(scale_budget_ms_ = budget_ms);
  // The rest of a picture's time is independent of the number of pixels.
  scale_->drew(options_.raster_ms ? options_.raster_ms(planned) : view_.last_times().raster_ms);
  display_.set_scale(scale_->value());
  view_.set_min_contribution(scale_->min_contribution_px());
  return {};
}

Result<void> HeadsetRun::run(const std::atomic<bool>& interrupted) {
  client_.start(stream_);
  const int64_t begun_ns = now_ns();
  while (!interrupted) {
    if (auto taken = poll_updates(); !taken) return taken;
    auto planned = display_.wait_frame();
    if (!planned) break;
    if (auto taken = poll_updates(); !taken) return taken;  // process updates received during the wait
    display_.set_notice(notice_.text(run_message_.empty() ? view_.notice() : run_message_));
    if (placed_) send_hands(planned->display_time_ns);
    if (auto done = planned->views.empty() || !placed_ ? display_.submit(*planned, {}) : draw(*planned);
        !done)
      return done;
    const double shown_s = seconds_from_ns(now_ns() - (placed_ ? placed_ns_ : begun_ns));
    if (options_.seconds > 0 &&
        shown_s >= (placed_ ? options_.seconds : std::max(options_.seconds, kFirstFrameTimeout_s)))
      break;
  }
  return {};
}

HeadsetRunSummary HeadsetRun::summary() const {
  HeadsetRunSummary summary;
  summary.runtime = display_.runtime_name();
  summary.renderer = view_.renderer_name();
  summary.counts = display_.counts();
  summary.hand_to_picture_ms_p50 = percentile(latencies_ms_, 0.5);
  summary.hand_to_picture_ms_p95 = percentile(latencies_ms_, 0.95);
  summary.draw_ms_p50 = percentile(draws_ms_, 0.5);
  summary.draw_ms_p95 = percentile(draws_ms_, 0.95);
  summary.vibrations = vibrations_;
  return summary;
}

// Null if the runtime ended the session or on an interrupt.
Result<std::unique_ptr<ConnectedScene>> load_in_headset(SceneLoader& loading, HeadsetDisplay& display,
                                                        const std::atomic<bool>& interrupted) {
  while (!loading.wait(0)) {
    const auto planned = display.wait_frame();  // paced by the display
    if (!planned || interrupted) return std::unique_ptr<ConnectedScene>();
    display.set_notice(loading.progress().text);
    if (auto submitted = display.submit(*planned, {}); !submitted) return submitted.error();
  }
  return loading.take();
}

}  // namespace

Result<HeadsetRunSummary> run_headset(const HeadsetRunOptions& options, HeadsetDisplay& display,
                                      const std::atomic<bool>& interrupted) {
  // Created before loading starts, since it uses the display's device on this thread.
  auto renderer = choose_renderer(options.renderer, display.device());
  if (!renderer) return renderer.error();
  SceneLoader loading(options, [&] { return std::move(renderer); });
  auto live = load_in_headset(loading, display, interrupted);
  if (!live) return live.error();
  if (!*live) {
    if (auto finished = display.finish(); !finished) return finished.error();
    HeadsetRunSummary summary;
    summary.runtime = display.runtime_name();
    summary.counts = display.counts();
    return summary;
  }
  HeadsetRun run(options, *(*live)->client, (*live)->objects, (*live)->view, display);
  const auto done = run.run(interrupted);
  (*live)->stop.request_stop();  // running fetches are not needed any more
  const auto finished = display.finish();
  const auto stopped =
      (*live)->client->stop();  // before the run's stream is destroyed, which the reader calls
  if (!stopped) log_warn("%s", stopped.error().message.c_str());
  if (!done) return done.error();
  if (!finished) return finished.error();
  return run.summary();
}

std::string summary_text(const HeadsetRunSummary& summary) {
  const auto count = [](uint64_t value) { return static_cast<unsigned long long>(value); };
  return format_text("%llu pictures to %s by %s; %llu sessions, %llu lost, %llu recentred\n",
                     count(summary.counts.pictures), summary.runtime.c_str(), summary.renderer.c_str(),
                     count(summary.counts.sessions), count(summary.counts.losses),
                     count(summary.counts.recentres)) +
         format_text("input latency p50 %.0f ms, p95 %.0f ms; drawing p50 %.1f ms, p95 %.1f ms\n",
                     summary.hand_to_picture_ms_p50, summary.hand_to_picture_ms_p95, summary.draw_ms_p50,
                     summary.draw_ms_p95);
}

}  // namespace livegs
