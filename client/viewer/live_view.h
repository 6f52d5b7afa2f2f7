// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>

#include "core/result.h"
#include "render/choose_renderer.h"
#include "render/scene_view.h"
#include "stream/asset_cache.h"
#include "stream/session_client.h"
#include "trust/server_access.h"
#include "viewer/asset_library.h"

namespace livegs {

// What every display needs of a server.
struct JoinOptions {
  std::string address;
  std::shared_ptr<const ServerAccess> access;  // null: in the clear
  std::filesystem::path cache;                 // of fetched assets; empty: the user's
  double connect_timeout_s = 5;
  double reconnect_s = std::numeric_limits<double>::infinity();  // how long a server that went away is looked for
  RendererChoice renderer = RendererChoice::Auto;
  double most_mbit_s = 0;  // what the link can take; 0: whatever the server gives
};

ConnectOptions connect_options(const JoinOptions& options);
// Of fetched assets, in this folder; empty: the user's.
Result<AssetCache> asset_cache(const std::filesystem::path& folder);

// A session that looks for its server again, also one that was started anew; what it has fetched; and the view that draws
// it, with all that the scene shows.
struct LiveView {
  LiveView(std::unique_ptr<SessionClient> joined, AssetCache kept, std::unique_ptr<SplatRenderer> renderer)
      : client(std::move(joined)), cache(std::move(kept)), assets(*client, cache), view(std::move(renderer)) {}

  const std::unique_ptr<SessionClient> client;
  const AssetCache cache;
  AssetLibrary assets;
  SceneView view;
};
using MakeRenderer = std::function<Result<std::unique_ptr<SplatRenderer>>()>;
Result<std::unique_ptr<LiveView>> join_live(const JoinOptions& options, const MakeRenderer& make_renderer);

}  // namespace livegs
