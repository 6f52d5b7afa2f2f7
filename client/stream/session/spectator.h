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

// Watches a scene by the frames its server publishes (proto/frame_format.md, "Publications"): no session, no
// hands, and no trace on the server but a subscription. However slow the sink is, the next frame it gets is
// the newest. What frames do not carry is asked for over gRPC when their event number is a new one; frames of
// a scene that is not known yet, or not any more, are left out.
class Spectator {
 public:
  // `server` is HOST:PORT of its gRPC, `published` what livegs-server --publish said, tcp://127.0.0.1:PORT.
  // Asks for the scene, again until the time is up while nobody answers or it is being built.
  static Result<std::unique_ptr<Spectator>> subscribe(const std::string& server, const std::string& published,
                                                      std::shared_ptr<const ServerAccess> access = nullptr,
                                                      double timeout_s = 5.0);
  ~Spectator();

  const JoinedScene& scene() const;  // as of subscribe()
  // As of SessionClient::fetch_asset(), in one attempt. Any thread.
  Result<void> fetch_asset(const std::string& hash, uint64_t asset_bytes, uint64_t offset,
                           const TakeChunk& take);

  // Calls the sink on a thread of its own until stop(). Once.
  void start(StreamSink& sink);
  void stop();

  struct Totals {
    uint64_t frames = 0;     // given to the sink
    uint64_t left_out = 0;   // of another scene than is known
    uint64_t described = 0;  // times the scene was asked for
  };
  Totals totals() const;  // any thread

 private:
  struct Connection;
  explicit Spectator(std::unique_ptr<Connection> connection);
  std::unique_ptr<Connection> connection_;
};

}  // namespace livegs
