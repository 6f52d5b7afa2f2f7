// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <stop_token>
#include <string>

#include "core/input_sample.h"
#include "core/result.h"
#include "core/view_cone.h"
#include "stream/received/asset_cache.h"
#include "stream/received/received.h"
#include "trust/server_access.h"

namespace livegs {

// So long a program that is to end by itself (--seconds) waits for its first frame, if it is not to run for
// longer anyway.
inline constexpr double kFirstFrameTimeout_s = 10;

struct ConnectOptions {
  double timeout_s = 5.0;  // for the server to be there and its scene to be built
  std::string client_name = "livegs-client";
  std::shared_ptr<const ServerAccess> access;  // null: in the clear
  double most_mbit_s = 0;                      // what the link can take; 0: whatever the server gives
  double rate_hz = 0;           // frames a second that it has a use for, 5 or more; 0: one each tick
  uint32_t position_bits = 16;  // of elastic objects' positions along their longest side: 16, 18 or 20
  v1::JoinRequest::Encoding encoding = v1::JoinRequest::DRIVERS;  // of frames
  double first_kernels_s =
      10;  // the first frame of kernels may take; twice as long for each stream that brought none, up to 30 s
  // How long a server that went away is looked for before the session is over; infinity: until stop().
  double reconnect_s = 10.0;
  // Whether a server that said goodbye is looked for, too.
  bool reconnect_after_drain = false;
  // Once it is requested, from any thread, join() and fetches that are under way or come later end at once
  // with Unavailable, and so does the session.
  std::stop_token stop;
};

// One session with a server, which outlives its connections: when the stream breaks, or nothing came for a
// second (longer with frames of kernels, session_stream.h), it connects again (stream/retry_schedule.h),
// joins with its session's id, tells the sink what has changed meanwhile and opens a new stream. Kernels that
// are too large for the link end it after three streams without a frame. Errors name the address and the
// remedy.
class SessionClient {
 public:
  // Connects and joins. Tries again until the time is up while nobody answers or the scene is being built;
  // not when the server shows another certificate than it should or refuses the token.
  static Result<std::unique_ptr<SessionClient>> join(const std::string& address,
                                                     const ConnectOptions& options);
  ~SessionClient();

  const JoinedScene& scene() const;  // as of join()

  // The bytes of an asset from `offset` on, in order, given to `take`; on a connection of its own. Stops
  // early, with the error, when `take` fails. `asset_bytes` is what the description says. A connection that
  // breaks is made again and goes on where it was, until reconnect_s have passed without a byte. Any thread.
  Result<void> fetch_asset(const std::string& hash, uint64_t asset_bytes, uint64_t offset,
                           const TakeChunk& take);

  Result<v1::AnalyzeObjectReply> analyze(const std::string& object);

  // Opens the stream and keeps one open, on threads of its own that call `sink`. Once.
  void start(StreamSink& sink);
  // A sample to send; any thread. Lost while there is no stream: what hands did then is over.
  void send(const InputSample& sample);
  // What this client looks at from now on; any thread. What is outside is sent less often. It holds until the
  // next call, for streams that are opened anew too; without a call everything is seen.
  void set_view(const ViewCone& view);
  // Ends the session and waits for its threads. OK when this end wanted it or the server announced it; else
  // why it could not go on. More than once is fine.
  Result<void> stop();
  // Whether the session has ended by itself.
  bool ended() const;

 private:
  struct Connection;
  explicit SessionClient(std::unique_ptr<Connection> connection);
  std::unique_ptr<Connection> connection_;
};

}  // namespace livegs
