// SPDX-License-Identifier: Apache-2.0
#include "viewer/runs/replay_run.h"

#include <mutex>

#include "core/log.h"
#include "core/text/format_text.h"
#include "render/choose_camera.h"
#include "stream/replay/recording_playback.h"
#include "viewer/live/connected_scene.h"
#include "viewer/output/player.h"
#include "viewer/output/write_pictures.h"
#include "xr/offscreen_display.h"

namespace livegs {
namespace {

// A section of a recording; its assets are requested as objects appear.
class Stretch final : public ItemSource {
 public:
  Stretch(RecordingPlayback& playback, AssetLibrary& assets, double seconds,
          const std::atomic<bool>& interrupted)
      : playback_(playback), assets_(assets), seconds_(seconds), interrupted_(interrupted) {}

  std::optional<StreamItem> take() override {
    if (interrupted_) return std::nullopt;
    auto item = playback_.take();
    if (!item) return item;
    if (const auto* added = std::get_if<ObjectAdded>(&*item)) assets_.request(added->object);
    if (const auto* changed = std::get_if<ObjectChanged>(&*item)) assets_.request(changed->object);
    if (const auto* frame = std::get_if<ReceivedFrame>(&*item)) {
      if (!first_ns_) first_ns_ = frame->drivers->simulated_ns;
      const int64_t passed_ns = frame->drivers->simulated_ns - *first_ns_;
      if (seconds_ > 0 && static_cast<double>(passed_ns) > 1e9 * seconds_) return std::nullopt;
    }
    return item;
  }

 private:
  RecordingPlayback& playback_;
  AssetLibrary& assets_;
  const double seconds_;
  const std::atomic<bool>& interrupted_;
  std::optional<int64_t> first_ns_;
};

}  // namespace

AssetLibrary::FetchAsset assets_of_recording(const std::filesystem::path& file) {
  struct Held {
    std::mutex mutex;  // guards the reader
    std::optional<RecordingReader> reader;
  };
  return [file, held = std::make_shared<Held>()](const std::string& hash, uint64_t total, uint64_t offset,
                                                 const TakeChunk& take) -> Result<void> {
    std::lock_guard lock(held->mutex);
    if (!held->reader) {
      auto opened = RecordingReader::open(file);
      if (!opened) return opened.error();
      held->reader.emplace(std::move(*opened));
    }
    auto bytes = held->reader->asset(hash);
    if (!bytes && bytes.error().code == ErrorCode::NotFound) {
      return not_found("asset " + hash.substr(0, 12) + ": found neither in the cache nor in " +
                       file.string() +
                       "; join its server once, or record with assets (livegs ctl record start --assets, "
                       "livegs-server --record-assets)");
    }
    if (!bytes) return bytes.error();
    if (bytes->size() != total || offset > total)
      return invalid_data(file.string() + ": an embedded asset has the wrong size; copy the recording again");
    return take(offset, total, std::span(*bytes).subspan(offset));
  };
}

Result<void> check_from(const ReplayOptions& options, double length_s) {
  if (options.from_s <= length_s) return {};
  return invalid_argument(format_text("--from %g: %s is %.3f s long; give an earlier time", options.from_s,
                                      options.file.c_str(), length_s));
}

Result<ReplaySummary> run_replay(const ReplayOptions& options, const std::atomic<bool>& interrupted) {
  auto playback = RecordingPlayback::open(options.file);
  if (!playback) return playback.error();
  if (auto checked = check_from(options, playback->length_s()); !checked) return checked.error();
  if (options.from_s > 0) {
    if (auto sought = playback->seek(options.from_s); !sought) return sought.error();
  }
  const auto picture = picture_choice(options.camera_file, options.size);
  if (!picture) return picture.error();
  const std::optional<Camera>& camera = picture->camera;
  const PictureSize size = picture->size;
  const auto cache = asset_cache(options.cache);
  if (!cache) return cache.error();
  auto renderer = choose_renderer(options.renderer);
  if (!renderer) return renderer.error();
  AssetLibrary assets(assets_of_recording(options.file), *cache);
  SceneView view(*std::move(renderer));
  view.set_shadows(options.shadows);
  auto display = OffscreenDisplay::open(
      {options.output, options.video_rate_hz, size.width, size.height, options.png_every, options.video});
  if (!display) return display.error();
  auto drawn_log = DrawnLog::create(options.output / "timings.csv");
  if (!drawn_log) return drawn_log.error();

  ReplaySummary summary;
  summary.frames_decoded_to_seek = playback->decoded();
  Stretch stretch(*playback, assets, options.seconds, interrupted);
  Player player(
      view, assets, stretch, **display, std::move(*drawn_log),
      [&](const SceneView& posed) -> Result<void> {
        const Camera chosen = camera.value_or(choose_camera(posed, size.width, size.height));
        (*display)->set_camera(chosen);
        return write_camera_file(options.output / "camera.json", chosen);
      },
      [&](const Image& image) { return write_first_picture(image, options.output); });
  const auto played = player.play();
  if (auto finished = (*display)->finish(); !finished) log_warn("%s", finished.error().message.c_str());
  if (!played) return played.error();
  if (auto written = write_last_picture(player, options.output); !written) return written.error();
  summary.file = options.file.string();
  summary.scene = playback->start().scene().name();
  summary.renderer = view.renderer_name();
  summary.notice = view.notice();
  summary.length_s = playback->length_s();
  summary.from_s = options.from_s;
  summary.assets = assets.totals();
  summary.drawn = player.summary();
  summary.error = playback->error();
  return summary;
}

std::string summary_text(const ReplaySummary& summary) {
  return format_text(
             "replay of %s: %s, %.1f s, from %.1f s; %zu frames decoded to get there; %zu assets, %zu of "
             "them out of the recording\n"
             "drawn: %llu pictures by %s; skinning p50 %.2f ms; render p50 %.2f ms\n",
             summary.file.c_str(), summary.scene.c_str(), summary.length_s, summary.from_s,
             summary.frames_decoded_to_seek, summary.assets.assets, summary.assets.fetched,
             static_cast<unsigned long long>(summary.drawn.pictures), summary.renderer.c_str(),
             summary.drawn.skin_ms_p50, summary.drawn.raster_ms_p50) +
         (summary.notice.empty() ? "" : "  " + summary.notice + "\n");
}

}  // namespace livegs
