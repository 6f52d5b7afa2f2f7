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

// What every display needs of a server.
struct JoinOptions {
  std::string address;
  std::shared_ptr<const ServerAccess> access;  // null: in the clear
  std::filesystem::path cache;                 // of fetched assets; empty: the user's
  double connect_timeout_s = 5;
  double reconnect_s =
      std::numeric_limits<double>::infinity();  // how long a server that went away is looked for
  RendererChoice renderer = RendererChoice::Auto;
  double most_mbit_s = 0;       // what the link can take; 0: whatever the server gives
  double rate_hz = 0;           // frames a second that there is a use for, 5 or more; 0: one each tick
  uint32_t position_bits = 16;  // of elastic objects' positions: 16, 18 or 20
  v1::JoinRequest::Encoding encoding = v1::JoinRequest::DRIVERS;  // of frames
  bool reconnect_after_drain = true;                              // looks for a server that said goodbye, too
  // Objects are shown with what has come of them; else, and where kernels are streamed, which are of the
  // whole, once they are whole.
  bool coarse_first = true;
};

// Of fetched assets, in this folder; empty: the user's.
Result<AssetCache> asset_cache(const std::filesystem::path& folder);

// A session that looks for its server again, also one that was started anew; what it has fetched; and the
// view that draws it, with all objects of the scene: whole, or as far as their assets have come. Made by
// SceneLoader.
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

  std::stop_source stop;  // ends the session and what is being fetched
  const std::unique_ptr<SessionClient> client;
  const AssetCache cache;
  AssetLibrary assets;
  ProgressiveObjects objects;
  SceneView view;
};

}  // namespace livegs
