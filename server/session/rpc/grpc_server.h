// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>

#include "core/result.h"
#include "scene/scene.h"
#include "session/publish/frame_publisher.h"
#include "session/tick/analysis_control.h"
#include "session/tick/run_control.h"
#include "session/tick/tick_result.h"

namespace livegs {

class ServerSecurity;
class SessionRecorder;

// HOST:PORT, checked: a port, and, unless `secure`, an address of this very machine: any other is listened on
// with TLS and tokens only.
Result<void> check_listen_address(const std::string& address, bool secure);

// The gRPC server with its sessions, its publisher, health and reflection. It knows a scene only as objects
// to describe and ticks to send on.
//
//   auto server = GrpcServer::listen("127.0.0.1:9780");        health NOT_SERVING, Join answers UNAVAILABLE
//   SimulationLoop loop(std::move(scene), server->ticks());
//   server->open(loop.scene(), loop); loop.start();            clients may join
//   loop.stop(); server->shut_down("reason");
class GrpcServer {
 public:
  // In the clear, or with `security` over TLS with a token for each call; it outlives the server. Fails with
  // Unavailable when the port is in use, InvalidArgument when the address may not be listened on.
  static Result<std::unique_ptr<GrpcServer>> listen(const std::string& address,
                                                    ServerSecurity* security = nullptr);
  ~GrpcServer();

  int port() const;
  TickSink& ticks();
  // For SimulationLoop::record_with(); livegs ctl starts and stops it.
  SessionRecorder& recorder();

  // Encodes every asset on the calling thread, then lets clients in. `inputs` outlives shut_down().
  void open(const std::string& scene_name, double rate_hz, std::span<const SceneObject* const> objects,
            InputSink& inputs);
  void open(const Scene& scene, InputSink& inputs);
  // How many clients may be there, 1 to kMaxSessions; kDefaultSessions when it is not called. Before open().
  void admit(size_t clients);
  // No client is sent more than this, megabits a second of messages, whatever it wishes for; before open().
  void cap_clients(double mbit_s);
  // From now on every frame is published there, too (ZmqPublisher::bind()); before the first tick. The
  // address as bound.
  Result<std::string> publish(const std::string& address);
  // From now on clients may analyse and edit what things are made of. `analysis` outlives shut_down().
  void open_analysis(AnalysisControl& analysis);
  // What `livegs ctl drain` calls, once or more, on a thread of gRPC's; it outlives shut_down().
  void open_drain(std::function<void(const std::string& reason)> drain);
  // From now on clients may halt, step and reset it. `run` outlives shut_down().
  void open_run(RunControl& run);
  // Encodes what this scene draws, on the calling thread, so that nothing waits for that when it takes the
  // other's place.
  void encode_ahead(const Scene& scene);

  // Tells every client, waits for their streams to end, at most three seconds, then ends them. More than once
  // is fine.
  void shut_down(const std::string& reason);

  SessionTable::Totals sessions() const;
  const SessionTable& session_table() const;  // for who counts
  size_t client_count() const;
  size_t streaming_count() const;  // of those, with an open stream
  PublisherSummary published() const;

 private:
  struct Parts;
  explicit GrpcServer(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace livegs
