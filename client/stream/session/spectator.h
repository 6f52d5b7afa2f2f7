// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "core/result.h"
#include "stream/received/asset_cache.h"
#include "stream/received/received.h"
#include "trust/server_access.h"

namespace livegs {

// Shows a scene from the frames its server publishes (proto/frame_format.md, "Publications"), without a
// session or input; the server sees a subscription only. A slow sink always receives the newest frame next.
// The scene description is requested over gRPC when the event number changes. Frames of an unknown or
// outdated scene are dropped.
class Spectator {
 public:
  // `server`: HOST:PORT of its gRPC service; `published`: the address printed by livegs-server --publish,
  // tcp://127.0.0.1:PORT. Requests the scene and retries until the timeout while no server answers or the
  // scene is being built.
  static Result<std::unique_ptr<Spectator>> subscribe(const std::string& server, const std::string& published,
                                                      std::shared_ptr<const ServerAccess> access = nullptr,
                                                      double timeout_s = 5.0);
  ~Spectator();

  const JoinedScene& scene() const;  // as of subscribe()
  // As SessionClient::fetch_asset(), in one attempt. Any thread.
  Result<void> fetch_asset(const std::string& hash, uint64_t asset_bytes, uint64_t offset,
                           const TakeChunk& take);

  // Calls the sink on an internal thread until stop(). Call once.
  void start(StreamSink& sink);
  void stop();

  struct Totals {
    uint64_t frames = 0;     // passed to the sink
    uint64_t left_out = 0;   // dropped: of an unknown scene
    uint64_t described = 0;  // number of scene requests
  };
  Totals totals() const;  // any thread

 private:
  struct Connection;
  explicit Spectator(std::unique_ptr<Connection> connection);
  std::unique_ptr<Connection> connection_;
};

}  // namespace livegs
