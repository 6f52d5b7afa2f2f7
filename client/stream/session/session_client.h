// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <stop_token>
#include <string>

#include "core/input_sample.h"
#include "core/result.h"
#include "core/view_cone.h"
#include "stream/channel/server_place.h"
#include "stream/received/asset_cache.h"
#include "stream/received/received.h"
#include "trust/server_access.h"

namespace livegs {

// Time a run with a fixed length (--seconds) waits for its first frame, unless the run is longer.
inline constexpr double kFirstFrameTimeout_s = 10;

struct ConnectOptions {
  double timeout_s = 5.0;  // until the server runs and its scene is built
  std::string client_name = "livegs-client";
  std::shared_ptr<const ServerAccess> access;  // null: no TLS
  double max_mbit_s = 0;                       // link bandwidth; 0: no limit
  double rate_hz = 0;                          // frames per second, at least 5; 0: one per tick
  uint32_t position_bits = 16;                 // elastic positions along the longest side: 16, 18 or 20
  v1::JoinRequest::Encoding encoding = v1::JoinRequest::DRIVERS;  // of frames
  bool starts_run = false;  // this client starts a simulation that waits for its first picture
  // Timeout of the first frame of kernels; doubled for each stream without a frame, up to 30 s.
  double first_kernels_s = 10;
  // Time to try reconnecting before the session ends; infinity: until stop().
  double reconnect_s = 10.0;
  // Whether to reconnect after an announced shutdown. A session always follows its server to a next one.
  bool reconnect_after_drain = false;
  // Once requested, from any thread, join() and all fetches end at once with Unavailable, and so does the
  // session.
  std::stop_token stop;
};

// One session with a server, which outlives its connections. When the stream breaks or is silent for a second
// (longer with frames of kernels, session_stream.h), the client reconnects (channel/retry_schedule.h), joins
// with its session id, reports changes to the sink and opens a new stream. When a server that shuts down
// names the next one, the client joins there: over TLS with the same certificate, or on this machine. Kernels
// that are too large for the link end the session after three streams without a frame. Errors name the
// address and the remedy.
class SessionClient {
 public:
  // Connects and joins. Retries until the timeout while no server answers or the scene is being built. Fails
  // at once if the server presents an unexpected certificate or refuses the token.
  static Result<std::unique_ptr<SessionClient>> join(const std::string& address,
                                                     const ConnectOptions& options);
  ~SessionClient();

  const JoinedScene& scene() const;  // as of join()
  // The current server of the session, for further connections to it.
  std::shared_ptr<const ServerPlace> place() const;

  // Fetches an asset from `offset` on, in order, into `take`, over a separate connection. Stops with the
  // error of `take` if it fails. `asset_bytes` is taken from the description. A broken connection is reopened
  // and the transfer resumed until no byte arrived for reconnect_s. Any thread.
  // `base_hash`: fetches the asset as an edit of this asset (FetchAssetRequest.base_hash).
  Result<void> fetch_asset(const std::string& hash, uint64_t asset_bytes, uint64_t offset,
                           const TakeChunk& take, const std::string& base_hash = {});

  // A fetch of an asset from the store that the server names (JoinReply.asset_store), which must not outlive
  // this client; null if no store has it, or after the store failed or refused. Any thread.
  AssetCache::Fetch stored_asset(const std::string& hash, uint64_t asset_bytes);

  Result<v1::AnalyzeObjectReply> analyze(const std::string& object);

  // Opens the stream and keeps it open on internal threads that call `sink`. Call once.
  void start(StreamSink& sink);
  // Queues a sample; any thread. Dropped while there is no stream, since the input is then out of date.
  void send(const InputSample& sample);
  // Sets what this client looks at; any thread. Objects outside are sent less often. Applies until the next
  // call, also to reopened streams. Before the first call everything counts as visible.
  void set_view(const ViewCone& view);
  // Ends the session and joins its threads. OK if this client or the server ended it in order; else the
  // reason. May be called repeatedly.
  Result<void> stop();
  // Whether the session has ended without stop().
  bool ended() const;

 private:
  struct Connection;
  explicit SessionClient(std::unique_ptr<Connection> connection);
  std::unique_ptr<Connection> connection_;
};

}  // namespace livegs
