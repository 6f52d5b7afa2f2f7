// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <limits>
#include <memory>
#include <stop_token>
#include <string>
#include <utility>

#include "core/result.h"
#include "render/choose_renderer.h"
#include "render/scene_view.h"
#include "stream/received/asset_cache.h"
#include "stream/session/session_client.h"
#include "trust/server_access.h"
#include "viewer/assets/progressive_objects.h"

namespace livegs {

// Connection options of all displays.
struct JoinOptions {
  std::string address;
  std::shared_ptr<const ServerAccess> access;  // null: no TLS
  std::filesystem::path cache;                 // for fetched assets; empty: the user's cache
  double connect_timeout_s = 5;
  double reconnect_s = std::numeric_limits<double>::infinity();  // time to try reconnecting
  RendererChoice renderer = RendererChoice::Auto;
  bool shadows = true;          // as in SceneView::set_shadows
  double max_mbit_s = 0;        // link bandwidth; 0: no limit
  double rate_hz = 0;           // frames per second, at least 5; 0: one per tick
  uint32_t position_bits = 16;  // elastic positions: 16, 18 or 20
  v1::JoinRequest::Encoding encoding = v1::JoinRequest::DRIVERS;  // of frames
  bool reconnect_after_drain = true;                              // also after an announced shutdown
  // Shows partially received objects. If false, or for streamed kernels, which refer to the complete asset,
  // objects appear once they are complete.
  bool coarse_first = true;
  bool starts_run = false;  // ConnectOptions::starts_run
};

// The cache of fetched assets in this folder; empty: the user's cache.
Result<AssetCache> asset_cache(const std::filesystem::path& folder);

// A session with automatic reconnect, its fetched assets, and the view that draws it. All objects of the
// scene are in the view, complete or partial. Created by SceneLoader.
struct ConnectedScene {
  ConnectedScene(std::stop_source ending, std::unique_ptr<SessionClient> joined, AssetCache kept,
                 std::unique_ptr<SplatRenderer> renderer)
      : stop(std::move(ending)),
        client(std::move(joined)),
        cache(std::move(kept)),
        assets(*client, cache, stop.get_token()),
        objects(assets),
        view(std::move(renderer)) {}
  ~ConnectedScene() { stop.request_stop(); }

  std::stop_source stop;  // ends the session and running fetches
  const std::unique_ptr<SessionClient> client;
  const AssetCache cache;
  AssetLibrary assets;
  ProgressiveObjects objects;
  SceneView view;
};

}  // namespace livegs
