// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>

#include "core/result.h"
#include "scene/scene.h"
#include "session/assets/client_store.h"
#include "session/publish/frame_publisher.h"
#include "session/support/successor.h"
#include "session/tick/analysis_control.h"
#include "session/tick/author_control.h"
#include "session/tick/run_control.h"
#include "session/tick/tick_result.h"

namespace livegs {

class ServerSecurity;
class SessionRecorder;

// Checks HOST:PORT: a valid port and, unless `secure`, a loopback address. Other addresses require TLS and
// tokens.
Result<void> check_listen_address(const std::string& address, bool secure);

// The gRPC server with its sessions, publisher, health checks and reflection, and on the same port the web
// server. Its only inputs from a scene are object descriptions and ticks.
//
//   auto server = GrpcServer::listen("127.0.0.1:9780");        health NOT_SERVING, Join returns UNAVAILABLE
//   SimulationLoop loop(std::move(scene), server->ticks());
//   server->open(loop.scene(), loop); loop.start();            clients may join
//   loop.stop(); server->shut_down("reason");
class GrpcServer {
 public:
  // Without TLS if `security` is null, else with TLS and a token per call; `security` must outlive the
  // server. Unavailable if the port is in use, InvalidArgument if check_listen_address() fails.
  static Result<std::unique_ptr<GrpcServer>> listen(const std::string& address,
                                                    ServerSecurity* security = nullptr);
  ~GrpcServer();

  // WebServer::allow_origins(); before open().
  void allow_origins(std::vector<std::string> origins);
  // The address of a store: pages may connect to its origin. Before clients request pages.
  void allow_store(const std::string& url);
  // The store from which clients fetch the assets that it has. Before open().
  void use_store(ClientStore store);
  uint64_t asset_bytes_sent() const;  // by this server to clients
  int port() const;
  // Links to the page, with a new one-time code that becomes a token of scope INTERACT; an earlier code is no
  // longer valid. Without TLS, browsers need no token. Any thread.
  v1::BrowserLink new_browser_link();
  TickSink& ticks();
  // For SimulationLoop::record_with(); controlled by livegs ctl.
  SessionRecorder& recorder();

  // Encodes every asset on the calling thread, then lets clients join. `inputs` must outlive shut_down().
  void open(const std::string& scene_name, double rate_hz, std::span<const SceneObject* const> objects,
            InputSink& inputs);
  void open(const Scene& scene, InputSink& inputs);
  // Maximum number of sessions, 1 to kMaxSessions; kDefaultSessions by default. Call before open().
  void admit(size_t clients);
  // Limits the message rate of each client, megabits a second, whatever it requests. Call before open().
  void cap_clients(double mbit_s);
  // Publishes every frame there too (ZmqPublisher::bind()); returns the bound address. Call before the first
  // tick.
  Result<std::string> publish(const std::string& address);
  // Enables analysis and edits of materials. `analysis` must outlive shut_down().
  void open_analysis(AnalysisControl& analysis);
  // Callback for `livegs ctl drain`, called one or more times on a gRPC thread; must outlive shut_down().
  void open_drain(std::function<void(const std::string& reason)> drain);
  // Enables pause, step and reset. `run` must outlive shut_down().
  void open_run(RunControl& run);
  // Enables editing of the scene. `author` must outlive shut_down().
  void open_author(AuthorControl& author);
  bool starter_joined() const;  // GrpcService::starter_joined()
  // Encodes the assets of this scene on the calling thread, so that no encoding is pending when it replaces
  // the current scene.
  void encode_ahead(const Scene& scene);

  // Sends the reason and the successor to every client, waits up to three seconds for their streams to end,
  // then aborts them. With a successor, a client that has lost its connection has this time to connect again.
  // Clients with a token of the fleet get one for the successor if its name is known. May be called more than
  // once.
  void shut_down(const std::string& reason, const Successor& successor = {});

  SessionTable::Totals sessions() const;
  const SessionTable& session_table() const;  // for metrics
  size_t client_count() const;
  size_t streaming_count() const;  // sessions with an open stream
  PublisherSummary published() const;

 private:
  struct Parts;
  explicit GrpcServer(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace livegs
