// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <grpcpp/client_context.h>

#include <atomic>
#include <condition_variable>
#include <deque>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "core/input_sample.h"
#include "core/result.h"
#include "core/view_cone.h"
#include "livegs/v1/session.grpc.pb.h"
#include "stream/received/frame_reader.h"
#include "stream/received/known_objects.h"
#include "stream/received/received.h"
#include "stream/time/clock_offset.h"
#include "stream/time/tick_aim.h"

namespace livegs {

// Silence after which the server counts as lost. The server sends at least every quarter of a second, and a
// Wi-Fi stall of 300 ms is tolerated.
inline constexpr int64_t kServerTimeout_ns = 1'000'000'000;
// Upper bound of that timeout for frames of kernels, which may take seconds on a slow link. The timeout is
// longer before the first frame, and a multiple of the longest gap between frames afterwards.
inline constexpr int64_t kMaxSilence_ns = 30'000'000'000;

// One Stream rpc of a session, from opening to status. Exposes gRPC types: for session_client.cpp only.
class SessionStream {
 public:
  // Objects that outlive the stream. The sink is called by run() and its reader only; clock and objects must
  // not be used by others during run().
  struct Ends {
    StreamSink& sink;
    ClockOffset& clock;
    KnownObjects& objects;
  };
  // `encoding`: frame encoding reported by Join. `first_silence_ns`: timeout before the first frame.
  SessionStream(v1::LiveGs::Stub& stub, std::string session_id, double rate_hz,
                v1::JoinRequest::Encoding encoding, int64_t first_silence_ns, Ends ends);

  struct Outcome {
    grpc::Status status;
    std::optional<Error> error;  // received data is unusable; a new stream would not help
    std::string reason;          // readable reason for the break
    bool silent = false;         // timed out
    bool drained = false;        // the server announced its shutdown, and without a next server
    std::optional<v1::NextServer> next_server;  // where the session continues
    uint64_t frames = 0;
    int64_t last_message_ns = 0;  // time of the last message, or of the opening
  };
  // Opens the stream and returns when it is over. One thread reads and calls the sink, another sends inputs,
  // acknowledgements and a keepalive at least every 50 ms. Call once.
  Outcome run();
  // Any thread. send() queues a sample for the tick from TickAim; each message carries the last three
  // samples, or more if more are new. stop() half-closes the stream; it is cancelled if the server does not
  // end it within a second.
  void send(const InputSample& sample);
  void set_view(const ViewCone& view);  // sent with the next message
  void stop();

 private:
  void read();
  void write();
  int64_t longest_silence_ns() const;  // requires the lock
  Result<void> take(v1::ServerMessage& message, int64_t received_ns);
  Result<void> take(const v1::SessionEvent& event);
  void take_clock(const v1::ServerMessage& message, int64_t received_ns);
  void warn_of_late_kernels(const ReceivedFrame& frame);

  v1::LiveGs::Stub& stub_;
  const std::string session_id_;
  Ends ends_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::ClientMessage, v1::ServerMessage>> stream_;
  std::atomic<int64_t> last_message_ns_{0};
  std::atomic<int64_t> longest_gap_ns_{0};  // between messages, or from the opening to the first
  const int64_t first_silence_ns_;

  FrameReader frames_;  // reader thread only, like the next
  int64_t echoed_ns_ = 0;
  const bool streams_kernels_;
  size_t late_kernel_frames_ = 0;  // consecutive
  bool warned_ = false;
  int64_t keyframe_requested_ns_ = std::numeric_limits<int64_t>::min() / 2;  // time of the last request

  std::mutex mutex_;  // guards everything below
  // Used by the writer alone: each spurious wake-up costs as much as a frame.
  std::condition_variable to_send_;
  std::condition_variable over_;  // for run()
  Outcome outcome_;
  TickAim aim_;
  std::deque<InputSample> samples_;  // the last three, or the unsent ones if they are more
  size_t unsent_samples_ = 0;        // at the end of samples_
  std::optional<ViewCone> view_;     // not sent yet
  uint64_t acknowledged_tick_ = 0;
  bool acknowledgement_new_ = false;
  bool keyframe_wanted_ = false;
  bool stopping_ = false;
  bool ended_ = false;
};

}  // namespace livegs
