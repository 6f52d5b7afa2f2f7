// SPDX-License-Identifier: Apache-2.0
#include "viewer/live/scene_loader.h"

#include <pthread.h>

#include <chrono>
#include <utility>

#include "core/text/format_text.h"
#include "stream/received/frame_reader.h"

namespace livegs {
namespace {

// "3.1 of 12.4 MB", "8 of 40 kB".
std::string share_text(uint64_t arrived_bytes, uint64_t bytes) {
  const auto arrived = static_cast<double>(arrived_bytes), all = static_cast<double>(bytes);
  return bytes < 1'000'000 ? format_text("%.0f of %.0f kB", 1e-3 * arrived, 1e-3 * all)
                           : format_text("%.1f of %.1f MB", 1e-6 * arrived, 1e-6 * all);
}

std::string text_of(const AssetLibrary::Progress& progress) {
  if (progress.object.empty()) return "assembling the scene";
  const std::string count = format_text("\n%zu of %zu assets loaded", progress.ready, progress.assets);
  if (progress.object_arrived_bytes >= progress.object_bytes) return progress.object + ": decoding" + count;
  return progress.object + ": " + share_text(progress.object_arrived_bytes, progress.object_bytes) + count;
}

}  // namespace

SceneLoader::SceneLoader(JoinOptions options, MakeRenderer make_renderer, Check check)
    : options_(std::move(options)), make_renderer_(std::move(make_renderer)), check_(std::move(check)) {
  thread_ = std::thread([this] {
    pthread_setname_np(pthread_self(), "loading");
    auto loaded = load();
    {
      std::lock_guard lock(mutex_);
      loading_ = nullptr;
      done_.emplace(std::move(loaded));
    }
    changed_.notify_all();
  });
}

SceneLoader::~SceneLoader() {
  if (!thread_.joinable()) return;  // the thread was joined by take()
  stop_.request_stop();
  thread_.join();
}

bool SceneLoader::wait(double seconds) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, std::chrono::duration<double>(seconds), [&] { return done_.has_value(); });
}

SceneLoader::Progress SceneLoader::progress() const {
  std::lock_guard lock(mutex_);
  if (!loading_) return {"connecting to " + options_.address, 0};
  const AssetLibrary::Progress assets = loading_->assets.progress();
  const double share =
      assets.bytes > 0 ? static_cast<double>(assets.arrived_bytes) / static_cast<double>(assets.bytes) : 0;
  return {text_of(assets), share};
}

Result<std::unique_ptr<ConnectedScene>> SceneLoader::take() {
  thread_.join();
  return *std::move(done_);
}

Result<void> SceneLoader::show_scene(ConnectedScene& live) const {
  const bool kernels = FrameReader::is_kernel_encoding(options_.encoding);
  if (options_.coarse_first && !kernels) live.assets.show_parts();
  const std::vector<StreamedObject>& objects = live.client->scene().objects;
  for (const StreamedObject& object : objects) live.objects.request(object);
  for (const StreamedObject& object : objects) {
    if (stop_.stop_requested()) return Error{ErrorCode::Unavailable, "loading was cancelled"};
    if (auto added = live.objects.add(object, live.view); !added) return added;
  }
  return {};
}

Result<std::unique_ptr<ConnectedScene>> SceneLoader::load() {
  ConnectOptions connect;
  connect.access = options_.access;
  connect.max_mbit_s = options_.max_mbit_s;
  connect.rate_hz = options_.rate_hz;
  connect.position_bits = options_.position_bits;
  connect.encoding = options_.encoding;
  connect.starts_run = options_.starts_run;
  connect.timeout_s = options_.connect_timeout_s;
  connect.reconnect_s = options_.reconnect_s;
  connect.reconnect_after_drain = options_.reconnect_after_drain;
  connect.stop = stop_.get_token();
  auto cache = asset_cache(options_.cache);
  if (!cache) return cache.error();
  auto joined = SessionClient::join(options_.address, connect);
  if (!joined) return joined.error();
  if (check_) {
    if (auto checked = check_((*joined)->scene()); !checked) return checked.error();
  }
  auto renderer = make_renderer_();
  if (!renderer) return renderer.error();
  auto live =
      std::make_unique<ConnectedScene>(stop_, std::move(*joined), std::move(*cache), std::move(*renderer));
  live->view.set_shadows(options_.shadows);
  {
    std::lock_guard lock(mutex_);
    loading_ = live.get();
  }
  auto loaded = show_scene(*live);
  {
    std::lock_guard lock(mutex_);
    loading_ = nullptr;  // the scene may be destroyed before the next progress()
  }
  if (!loaded) return loaded.error();
  return live;
}

}  // namespace livegs
