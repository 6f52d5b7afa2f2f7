// SPDX-License-Identifier: Apache-2.0
#include "viewer/runs/spectate_run.h"

#include <algorithm>
#include <chrono>
#include <mutex>
#include <optional>
#include <string_view>
#include <thread>

#include "core/clock.h"
#include "core/log.h"
#include "core/text/format_text.h"
#include "render/choose_camera.h"
#include "stream/replay/playback_queue.h"
#include "trust/host_port.h"
#include "viewer/assets/load_scene.h"
#include "viewer/output/player.h"
#include "viewer/output/write_pictures.h"
#include "xr/offscreen_display.h"

namespace livegs {
namespace {

constexpr std::chrono::milliseconds kPollInterval{50};

// Puts everything into the queue of the drawing thread.
class Watcher final : public StreamSink {
 public:
  Watcher(AssetLibrary& assets, PlaybackQueue& queue, ReceivedLog log)
      : assets_(assets), queue_(queue), log_(std::move(log)) {}

  void on_lost(const std::string& reason) override { log_warn("%s", reason.c_str()); }
  void on_resumed(const ResumedSession& resumed) override {
    {
      std::lock_guard lock(mutex_);
      if (!resumed.same_server) log_.reset();
    }
    queue_.add(resumed);
  }
  void on_frame(ReceivedFrame frame) override {
    {
      std::lock_guard lock(mutex_);
      if (first_ns_ == 0) first_ns_ = frame.received_ns;
      last_ns_ = frame.received_ns;
      log_.add(frame);
    }
    queue_.add(std::move(frame));
  }
  void on_object_added(StreamedObject object) override {
    assets_.request(object);
    queue_.add(ObjectAdded{std::move(object)});
  }
  void on_object_changed(StreamedObject object) override {
    assets_.request(object);
    queue_.add(ObjectChanged{std::move(object)});
  }
  void on_object_removed(uint32_t object_id) override { queue_.add(ObjectRemoved{object_id}); }
  void on_draining(const std::string&) override {}

  // Both 0 before the first frame.
  struct Received {
    int64_t first_ns = 0, last_ns = 0;
  };
  Received received() const {
    std::lock_guard lock(mutex_);
    return {first_ns_, last_ns_};
  }
  ReceivedLog::Summary summary() const {
    std::lock_guard lock(mutex_);
    return log_.summary();
  }

 private:
  AssetLibrary& assets_;
  PlaybackQueue& queue_;
  mutable std::mutex mutex_;  // guards everything below
  ReceivedLog log_;
  int64_t first_ns_ = 0, last_ns_ = 0;
};

// ZeroMQ reports no error if nothing is published at an address.
Error nothing_came(const std::string& published, double waited_s) {
  constexpr std::string_view kTcp = "tcp://";
  const auto where = published.starts_with(kTcp)
                         ? parse_host_port(published.substr(kTcp.size()))
                         : Result<HostPort>(invalid_argument("does not start with tcp://"));
  const bool elsewhere = where && !where->loopback;
  return {ErrorCode::Unavailable,
          format_text("--subscribe %s: nothing was published there within %.1f s; %s", published.c_str(),
                      waited_s,
                      elsewhere ? "use livegs-client HOST:PORT for a server on another machine"
                                : "use the address printed by livegs-server --publish")};
}

}  // namespace

Result<SpectateSummary> run_spectator(const std::string& published, const OffscreenRunOptions& options,
                                      const std::atomic<bool>& interrupted) {
  const auto picture = picture_choice(options.camera_file, options.size);
  if (!picture) return picture.error();
  const std::optional<Camera>& camera = picture->camera;
  const PictureSize size = picture->size;
  const auto cache = asset_cache(options.cache);
  if (!cache) return cache.error();
  auto spectator =
      Spectator::subscribe(options.address, published, options.access, options.connect_timeout_s);
  if (!spectator) return spectator.error();
  auto renderer = choose_renderer(options.renderer);
  if (!renderer) return renderer.error();
  AssetLibrary assets(
      [&](const std::string& hash, uint64_t bytes, uint64_t offset, const TakeChunk& take) {
        return (*spectator)->fetch_asset(hash, bytes, offset, take);
      },
      *cache);
  SceneView view(*std::move(renderer));
  view.set_shadows(options.shadows);
  if (auto loaded = load_scene((*spectator)->scene(), assets, view); !loaded) return loaded.error();
  auto display = OffscreenDisplay::open(
      {options.output, options.video_rate_hz, size.width, size.height, options.png_every, options.video});
  if (!display) return display.error();
  auto received_log = ReceivedLog::create(options.output / "frames.csv");
  if (!received_log) return received_log.error();
  auto drawn_log = DrawnLog::create(options.output / "timings.csv");
  if (!drawn_log) return drawn_log.error();

  PlaybackQueue queue(kMaxBacklogBytes);
  Watcher watcher(assets, queue, std::move(*received_log));
  Player player(
      view, assets, queue, **display, std::move(*drawn_log),
      [&](const SceneView& posed) -> Result<void> {
        const Camera chosen = camera.value_or(choose_camera(posed, size.width, size.height));
        (*display)->set_camera(chosen);
        return write_camera_file(options.output / "camera.json", chosen);
      },
      [&](const Image& image) { return write_first_picture(image, options.output); });
  Result<void> played;
  std::atomic<bool> play_ended{false};
  std::thread drawer([&] {
    played = player.play();
    play_ended = true;
  });
  std::optional<Error> ended;
  const int64_t begun_ns = now_ns();
  const double patience_s =
      options.seconds > 0 ? std::min(options.seconds, options.connect_timeout_s) : options.connect_timeout_s;
  // Healthy servers are silent between two frames.
  const double silence_s =
      std::max({options.reconnect_s, 1.0, 3 / std::max((*spectator)->scene().rate_hz, 0.1)});
  (*spectator)->start(watcher);
  for (; !interrupted && !play_ended; std::this_thread::sleep_for(kPollInterval)) {
    const int64_t now = now_ns();
    const Watcher::Received received = watcher.received();
    if (received.first_ns == 0) {
      if (seconds_from_ns(now - begun_ns) < patience_s) continue;
      ended = nothing_came(published, seconds_from_ns(now - begun_ns));
    } else if (options.seconds > 0 && seconds_from_ns(now - received.first_ns) >= options.seconds) {
      break;
    } else if (seconds_from_ns(now - received.last_ns) >= silence_s) {
      ended = Error{ErrorCode::Unavailable,
                    format_text("--subscribe %s: connection lost: nothing was published for %.1f s; check "
                                "that the server runs with --publish",
                                published.c_str(), seconds_from_ns(now - received.last_ns))};
    }
    if (ended) break;
  }
  (*spectator)->stop();
  queue.close();
  for (; !play_ended; std::this_thread::sleep_for(kPollInterval)) {
    if (interrupted) queue.abandon();
  }
  drawer.join();
  if (auto finished = (*display)->finish(); !finished) log_warn("%s", finished.error().message.c_str());
  if (!played) return played.error();
  if (ended && watcher.received().first_ns == 0) return *ended;
  if (auto written = write_last_picture(player, options.output); !written) return written.error();

  SpectateSummary summary;
  summary.published = published;
  summary.renderer = view.renderer_name();
  summary.notice = view.notice();
  summary.objects = (*spectator)->scene().objects.size();
  summary.spectated = (*spectator)->totals();
  summary.assets = assets.totals();
  summary.received = watcher.summary();
  summary.drawn = player.summary();
  summary.dropped_frames = queue.dropped_frames();
  summary.stream_error = ended;
  return summary;
}

std::string summary_text(const SpectateSummary& summary) {
  const auto count = [](uint64_t value) { return static_cast<unsigned long long>(value); };
  return format_text(
             "spectator of %s: %zu objects, scene requested %llu times; %zu of %zu assets fetched\n"
             "received: %llu frames in %.1f s, %.1f per second; %llu ticks missed, %llu frames of unknown "
             "scenes dropped; staleness p50 %.2f ms, p99 %.2f ms; %.0f bytes per frame p50\n"
             "drawn: %llu pictures by %s\n",
             summary.published.c_str(), summary.objects, count(summary.spectated.described),
             summary.assets.fetched, summary.assets.assets, count(summary.received.frames),
             summary.received.seconds, summary.received.rate_hz, count(summary.received.missed_ticks),
             count(summary.spectated.left_out), summary.received.age_ms_p50, summary.received.age_ms_p99,
             summary.received.bytes_p50, count(summary.drawn.pictures), summary.renderer.c_str()) +
         (summary.notice.empty() ? "" : "  " + summary.notice + "\n");
}

}  // namespace livegs
