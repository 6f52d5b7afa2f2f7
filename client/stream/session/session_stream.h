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

// A server that says nothing for so long is not there: it says something every quarter of a second. A Wi-Fi
// that stalls for 300 ms is waited out.
inline constexpr int64_t kServerTimeout_ns = 1'000'000'000;
// Nor while a message is on its way, though, and a frame of kernels may take seconds over a slow link. So
// before its first frame more is waited for, and between frames of kernels some times what the longest took;
// so much at most.
inline constexpr int64_t kMaxSilence_ns = 30'000'000'000;

// One Stream rpc of a session, from its opening to its status. gRPC types: for session_client.cpp only.
class SessionStream {
 public:
  // What outlives it: the sink is called by run() and its reader only; clock and objects are touched by no
  // one else meanwhile.
  struct Ends {
    StreamSink& sink;
    ClockOffset& clock;
    KnownObjects& objects;
  };
  // `encoding`: of its frames, as Join said. `first_silence_ns`: how long nothing may come before the first
  // frame.
  SessionStream(v1::LiveGs::Stub& stub, std::string session_id, double rate_hz,
                v1::JoinRequest::Encoding encoding, int64_t first_silence_ns, Ends ends);

  struct Outcome {
    grpc::Status status;
    std::optional<Error> error;  // what came cannot be used; no other stream would bring anything better
    std::string reason;          // why it broke, for a person
    bool silent = false;         // nothing came for too long
    bool drained = false;        // the server said that it would
    uint64_t frames = 0;
    int64_t heard_ns = 0;  // when the last message came; or its opening
  };
  // Opens the stream and returns when it is over. A thread reads and calls the sink, another sends inputs,
  // acknowledgements and, at least every 50 ms, a sign of life. Once.
  Outcome run();
  // Any thread: a sample to send, meant for the tick that TickAim says; the last three travel in each
  // message. The end: the server answers a half close by ending the stream, and one that does not within a
  // second is left.
  void send(const InputSample& sample);
  void set_view(const ViewCone& view);  // travels with the next message
  void stop();

 private:
  void read();
  void write();
  int64_t longest_silence_ns() const;  // under the lock
  Result<void> take(v1::ServerMessage& message, int64_t received_ns);
  Result<void> take(const v1::SessionEvent& event);
  void take_clock(const v1::ServerMessage& message, int64_t received_ns);
  void warn_of_late_kernels(const ReceivedFrame& frame);

  v1::LiveGs::Stub& stub_;
  const std::string session_id_;
  Ends ends_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::ClientMessage, v1::ServerMessage>> stream_;
  std::atomic<int64_t> heard_ns_{0};
  std::atomic<int64_t> longest_gap_ns_{0};  // between messages, or from the opening to the first
  const int64_t first_silence_ns_;

  FrameReader frames_;  // the reader's thread only, like the next
  int64_t echoed_ns_ = 0;
  const bool streams_kernels_;
  size_t late_kernel_frames_ = 0;  // one after the other
  bool warned_ = false;
  int64_t key_frame_requested_ns_ = std::numeric_limits<int64_t>::min() / 2;  // for a key frame, last

  std::mutex mutex_;  // guards everything below
  std::condition_variable
      to_send_;  // for the writer alone: a thread that is woken for nothing costs as much as a frame
  std::condition_variable over_;  // for run()
  Outcome outcome_;
  TickAim aim_;
  std::deque<InputSample> samples_;  // the last three
  bool samples_new_ = false;
  std::optional<ViewCone> view_;  // that was not sent yet
  uint64_t acknowledged_tick_ = 0;
  bool acknowledgement_new_ = false;
  bool key_frame_wanted_ = false;
  bool stopping_ = false;
  bool ended_ = false;
};

}  // namespace livegs
