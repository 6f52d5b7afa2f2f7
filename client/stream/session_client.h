// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <string>

#include "core/input_sample.h"
#include "core/result.h"
#include "stream/asset_cache.h"
#include "stream/received.h"

namespace livegs {

struct ConnectOptions {
  double timeout_s = 5.0;  // for the server to be there and its scene to be built
  std::string client_name = "livegs-client";
};

// One session with a server. Errors name the address and the remedy.
class SessionClient {
 public:
  // Connects and joins. Tries again until the time is up while nobody answers or the scene is being built.
  static Result<std::unique_ptr<SessionClient>> join(const std::string& address,
                                                     const ConnectOptions& options);
  ~SessionClient();

  const JoinedScene& scene() const;

  // The bytes of an asset from `offset` on, in order, given to `take`; on a connection of its own. Stops
  // early, with the error, when `take` fails. `asset_bytes` is what the description says. Any thread.
  Result<void> fetch_asset(const std::string& hash, uint64_t asset_bytes, uint64_t offset,
                           const TakeChunk& take);

  Result<v1::AnalyzeObjectReply> analyze(const std::string& object);

  // Opens the stream: a thread reads and calls `sink`, another sends inputs and acknowledgements, and at
  // least every 50 ms a sign of life. Once.
  void start(StreamSink& sink);
  // A sample to send; any thread. The last three travel in each message.
  void send(const InputSample& sample);
  // Ends the stream and waits for both threads. OK when this end wanted it or the server announced it; else
  // why it broke. More than once is fine.
  Result<void> stop();
  // Whether the stream has ended by itself.
  bool ended() const;

 private:
  struct Connection;
  explicit SessionClient(std::unique_ptr<Connection> connection);
  std::unique_ptr<Connection> connection_;
};

}  // namespace livegs
