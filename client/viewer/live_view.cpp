// SPDX-License-Identifier: Apache-2.0
#include "viewer/live_view.h"

#include "viewer/load_scene.h"

namespace livegs {

ConnectOptions connect_options(const JoinOptions& options) {
  ConnectOptions connect;
  connect.access = options.access;
  connect.most_mbit_s = options.most_mbit_s;
  connect.timeout_s = options.connect_timeout_s;
  connect.reconnect_s = options.reconnect_s;
  return connect;
}

Result<AssetCache> asset_cache(const std::filesystem::path& folder) {
  if (!folder.empty()) return AssetCache(folder);
  auto own = AssetCache::default_folder();
  if (!own) return own.error();
  return AssetCache(std::move(*own));
}

Result<std::unique_ptr<LiveView>> join_live(const JoinOptions& options, const MakeRenderer& make_renderer) {
  ConnectOptions connect = connect_options(options);
  connect.outlive_draining = true;
  auto joined = SessionClient::join(options.address, connect);
  if (!joined) return joined.error();
  auto renderer = make_renderer();
  if (!renderer) return renderer.error();
  auto cache = asset_cache(options.cache);
  if (!cache) return cache.error();
  auto live = std::make_unique<LiveView>(std::move(*joined), std::move(*cache), std::move(*renderer));
  if (auto loaded = load_scene(live->client->scene(), live->assets, live->view); !loaded) return loaded.error();
  return live;
}

}  // namespace livegs
