// SPDX-License-Identifier: Apache-2.0
#include "viewer/runs/offscreen_run.h"

#include <chrono>
#include <map>
#include <thread>

#include "core/clock.h"
#include "core/log.h"
#include "core/text/format_text.h"
#include "render/choose_camera.h"
#include "stream/session/scene_control.h"
#include "stream/session/session_client.h"
#include "viewer/live/scene_loader.h"
#include "viewer/output/offscreen_sink.h"
#include "viewer/output/player.h"
#include "viewer/output/write_pictures.h"
#include "viewer/panels/object_summary.h"
#include "xr/offscreen_display.h"

namespace livegs {
namespace {

constexpr double kWaitSlice_s = 0.05;
constexpr int64_t kLoadingInterval_ns = 5'000'000'000;  // between log lines while the scene loads
constexpr std::chrono::milliseconds kOffscreenPollInterval{10};

// Inputs that are validated before connecting.
struct Prepared {
  PictureChoice picture;
  v1::InputScript script;
};

Result<Prepared> prepare(const OffscreenRunOptions& options) {
  Prepared prepared;
  auto picture = picture_choice(options.camera_file, options.size);
  if (!picture) return picture.error();
  prepared.picture = *picture;
  if (!options.script_file.empty()) {
    auto script = read_script_file(options.script_file);
    if (!script) return script.error();
    prepared.script = std::move(*script);
  } else if (!options.poke.empty()) {
    prepared.script = poke_script(options.poke);
  }
  return prepared;
}

// The object that the action names; empty for a ball shot at a point.
std::string named_by(const v1::InputScript::Action& action) {
  switch (action.kind_case()) {
    case v1::InputScript::Action::kPoke:
      return action.poke().object();
    case v1::InputScript::Action::kGrab:
      return action.grab().object();
    case v1::InputScript::Action::kBall:
      return action.ball().object();
    case v1::InputScript::Action::KIND_NOT_SET:
      break;
  }
  return {};
}

Result<void> check_names(const v1::InputScript& script, const JoinedScene& scene) {
  for (const v1::InputScript::Action& action : script.actions()) {
    const std::string name = named_by(action);
    if (action.has_ball() && action.ball().aim_case() != v1::InputScript::Ball::kObject) continue;
    std::string known;
    bool found = false;
    for (const StreamedObject& object : scene.objects) {
      if (object.environment) continue;
      found = found || object.name == name;
      known += (known.empty() ? "" : ", ") + object.name;
    }
    if (!found) return not_found("script: object \"" + name + "\" is not in the scene; available: " + known);
  }
  return {};
}

std::map<std::string, OffscreenSink::Target> script_targets(const JoinedScene& scene, const SceneView& view) {
  std::map<std::string, OffscreenSink::Target> targets;
  for (const StreamedObject& object : scene.objects) {
    const Eigen::AlignedBox3d bounds = view.bounds(object.id);
    if (object.environment || bounds.isEmpty()) continue;
    targets[object.name] = {object.id, bounds.sizes().maxCoeff()};
  }
  return targets;
}

}  // namespace

Result<OffscreenRunSummary> run_offscreen(const OffscreenRunOptions& options,
                                          const std::atomic<bool>& interrupted) {
  auto prepared = prepare(options);
  if (!prepared) return prepared.error();
  JoinOptions join = options;
  join.coarse_first = false;  // saved pictures show complete objects
  SceneLoader loading(
      std::move(join), [&] { return choose_renderer(options.renderer); },
      [&](const JoinedScene& joined) { return check_names(prepared->script, joined); });
  for (int64_t logged_ns = now_ns(); !loading.wait(kWaitSlice_s);) {
    if (interrupted) return Error{ErrorCode::Unavailable, "scene: loading was interrupted"};
    if (now_ns() - logged_ns < kLoadingInterval_ns) continue;
    logged_ns = now_ns();
    if (const auto now = loading.progress(); now.share > 0) log_info("loading: %.0f %%", 100 * now.share);
  }
  auto live = loading.take();
  if (!live) return live.error();
  SessionClient& client = *(*live)->client;
  AssetLibrary& assets = (*live)->assets;
  SceneView& view = (*live)->view;
  const JoinedScene& scene = client.scene();
  // Known to authors only; without that right, pictures have the default background.
  if (const auto document = SceneControl(options.address, options.access).scene(); document) {
    const auto& rgb = document->scene().background_rgb();
    if (rgb.size() == 3) view.set_background(Eigen::Vector3d(rgb[0], rgb[1], rgb[2]).cast<float>());
  }
  log_info("joined %s: %zu objects, %.0f Hz; %zu of %zu assets fetched, %.1f MB", options.address.c_str(),
           scene.objects.size(), scene.rate_hz, assets.totals().fetched, assets.totals().assets,
           static_cast<double>(assets.totals().fetched_bytes) * 1e-6);

  auto display = OffscreenDisplay::open({options.output, options.video_rate_hz, prepared->picture.size.width,
                                         prepared->picture.size.height, options.png_every, options.video});
  if (!display) return display.error();
  auto received_log = ReceivedLog::create(options.output / "frames.csv");
  if (!received_log) return received_log.error();
  auto drawn_log = DrawnLog::create(options.output / "timings.csv");
  if (!drawn_log) return drawn_log.error();

  PlaybackQueue queue(kMaxBacklogBytes);
  OffscreenSink recorder(client, assets, queue, std::move(*received_log), options.seconds);
  const auto on_first_frame = [&](const SceneView& posed) -> Result<void> {
    const Camera camera = prepared->picture.camera.value_or(
        choose_camera(posed, prepared->picture.size.width, prepared->picture.size.height));
    (*display)->set_camera(camera);
    if (prepared->script.actions_size() > 0) {
      recorder.begin_script(
          ScriptedHands(prepared->script, {camera.world_from_camera.position_m, scene.ball_speed_m_s}),
          script_targets(scene, posed));
    }
    return write_camera_file(options.output / "camera.json", camera);
  };
  Player player(view, assets, queue, **display, std::move(*drawn_log), on_first_frame,
                [&](const Image& picture) { return write_first_picture(picture, options.output); });
  Result<void> played;
  std::atomic<bool> play_ended{false};
  std::thread drawer([&] {
    played = player.play();
    play_ended = true;
  });

  log_info("stream: receiving %s, writing to %s",
           options.seconds > 0 ? format_text("%g s", options.seconds).c_str() : "until the server ends",
           options.output.c_str());
  client.start(recorder);
  while (!recorder.wait_done(kWaitSlice_s) && !client.ended() && !interrupted && !play_ended) {
  }
  const Result<void> streamed = client.stop();
  queue.close();
  if (!streamed) log_warn("%s", streamed.error().message.c_str());
  if (!play_ended && !interrupted) {
    log_info("stream ended after %.1f s; drawing the pictures after %.1f s", recorder.summary().seconds,
             player.played_s());
  }
  for (; !play_ended; std::this_thread::sleep_for(kOffscreenPollInterval)) {
    if (interrupted) queue.abandon();
  }
  drawer.join();
  auto finished = (*display)->finish();
  if (!finished) log_warn("%s", finished.error().message.c_str());
  if (auto written = write_last_picture(player, options.output); !written) return written.error();

  OffscreenRunSummary summary;
  summary.scene_address = options.address;
  summary.renderer = view.renderer_name();
  summary.notice = view.notice();
  summary.server_rate_hz = scene.stream_rate_hz;
  summary.objects = scene.objects.size();
  const std::map<uint32_t, StreamedObject> changed = recorder.changed_objects();
  for (const StreamedObject& object : scene.objects) {
    summary.kernels += object.kernel_count;
    const auto now = changed.find(object.id);
    if (!object.environment)
      summary.object_summaries.push_back(object_summary(now == changed.end() ? object : now->second));
  }
  summary.assets = assets.totals();
  summary.received = recorder.summary();
  summary.drawn = player.summary();
  summary.outages = recorder.outages();
  summary.dropped_frames = queue.dropped_frames();
  if (!played)
    summary.stream_error = played.error();
  else if (!streamed)
    summary.stream_error = streamed.error(), summary.error_logged = true;
  else if (recorder.gave_up())
    summary.stream_error =
        Error{ErrorCode::Unavailable,
              options.address + ": no frame arrived within " +
                  format_text("%.0f s; check the server with livegs ctl status", recorder.patience_s())};
  return summary;
}

std::string summary_text(const OffscreenRunSummary& summary) {
  std::string text;
  const auto count = [](uint64_t value) { return static_cast<unsigned long long>(value); };
  text += format_text("client of %s: %zu objects, %zu kernels; %zu of %zu assets fetched, %.1f MB\n",
                      summary.scene_address.c_str(), summary.objects, summary.kernels, summary.assets.fetched,
                      summary.assets.assets, static_cast<double>(summary.assets.fetched_bytes) * 1e-6);
  for (const std::string& line : summary.object_summaries) text += "  " + line + "\n";
  const ReceivedLog::Summary& received = summary.received;
  text += format_text("received: %llu frames in %.1f s, %.1f per second of %.1f; %llu ticks not sent\n",
                      count(received.frames), received.seconds, received.rate_hz, summary.server_rate_hz,
                      count(received.missed_ticks));
  if (summary.outages.count > 0) {
    const auto times = [&](uint64_t value, const char* word) {
      return format_text("%llu %s%s", count(value), word, value == 1 ? "" : "s");
    };
    text += "  " + times(summary.outages.count, "disconnect") + ", " +
            times(summary.outages.resumed, "reconnect") +
            format_text(" after %.1f s in total, %llu of them to a restarted server; last reason: %.80s\n",
                        summary.outages.seconds, count(summary.outages.restarted),
                        summary.outages.last_reason.c_str());
  }
  text += format_text(
      "  staleness p50 %.2f ms, p99 %.2f ms, uncertainty %.2f ms; %.0f bytes per frame p50, %.0f p99; "
      "server tick p50 %.2f ms, p99 %.2f ms\n",
      received.age_ms_p50, received.age_ms_p99, received.clock_uncertainty_ms, received.bytes_p50,
      received.bytes_p99, received.step_ms_p50, received.step_ms_p99);
  const DrawnLog::Summary& drawn = summary.drawn;
  text += format_text(
      "drawn: %llu pictures by %s; skinning p50 %.2f ms, p99 %.2f ms; render p50 %.2f ms, p99 %.2f ms\n",
      count(drawn.pictures), summary.renderer.c_str(), drawn.skin_ms_p50, drawn.skin_ms_p99,
      drawn.raster_ms_p50, drawn.raster_ms_p99);
  if (!summary.notice.empty()) text += "  " + summary.notice + "\n";
  if (summary.dropped_frames > 0) {
    text += format_text("  %llu frames dropped: the backlog was full; the video skips\n",
                        count(summary.dropped_frames));
  }
  return text;
}

}  // namespace livegs
