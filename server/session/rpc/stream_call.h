// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include <deque>
#include <memory>
#include <mutex>
#include <optional>

#include "core/token_bucket.h"
#include "session/sessions/client_session.h"
#include "session/sessions/session_table.h"

namespace livegs {

// Rate limit of client messages. A client at 240 Hz sends a sample and an acknowledgement per frame.
inline constexpr double kMaxMessagesPerSecond = 1000;

// One Stream rpc. A message is raw bytes: the client's own header and the shared tail of the frame, in one
// ByteBuffer. gRPC calls the On… functions on its own threads, unordered; the publisher calls the
// SessionWriter functions. Lives until OnDone.
//
// At most one read and one write are in progress. Finish is called once and never during a write, whichever
// event occurs first: half close, cancellation, bad message, failed write, close() or abort().
class StreamCall final : public grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                         public SessionWriter,
                         public std::enable_shared_from_this<StreamCall> {
 public:
  // `authorization`: the caller's rights; an error ends the call at once.
  static StreamCall* start(SessionTable& table, Result<Authorization> authorization,
                           grpc::CallbackServerContext& context);

  void wake() override;
  void send_keepalive(int64_t now_ns) override;
  void close(const std::string& reason) override;
  void end(const Error& why) override;
  void end_without_session() override;
  void abort() override;

 private:
  StreamCall(SessionTable& table, Authorization authorization, grpc::CallbackServerContext& context)
      : table_(table), authorization_(std::move(authorization)), context_(context) {}

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  std::optional<grpc::Status> take_message();  // a status ends the stream
  void write_next(const std::lock_guard<std::mutex>&);
  // False if the client has all that is in the tick and no frame is due, so that nothing was written.
  bool write(const SendWindow::Outgoing& outgoing, const std::lock_guard<std::mutex>&);
  void request_finish(const grpc::Status& status);
  void finish_if_idle(const std::lock_guard<std::mutex>&);

  SessionTable& table_;
  const Authorization authorization_;
  grpc::CallbackServerContext& context_;
  std::shared_ptr<StreamCall> self_;  // gRPC's reference, released in OnDone

  grpc::ByteBuffer incoming_;  // buffer of the current read

  std::mutex mutex_;                        // guards everything below
  std::shared_ptr<ClientSession> session_;  // set by the first message
  uint64_t stream_ = 0;                     // number of this stream within the session
  int64_t echoed_ns_ = 0;                   // sent_ns of the newest client message
  int64_t received_ns_ = 0;                 // when that message was received
  int64_t written_ns_ = 0;                  // when the last message was handed to gRPC
  struct Written {
    uint64_t tick = 0;
    int64_t stepped_ns = 0, written_ns = 0;
  };
  std::deque<Written> unacknowledged_;  // frames in flight, at most one window
  TokenBucket messages_{kMaxMessagesPerSecond, 2 * kMaxMessagesPerSecond};
  int position_bits_ = 16;  // requested at Join, like encoding_
  v1::JoinRequest::Encoding encoding_ = v1::JoinRequest::DRIVERS;
  std::optional<ViewCone> view_;  // newest view of the client
  StreamBaselinePtr baseline_;    // baseline of the last frame; null: the next frame is a keyframe
  v1::ServerMessage header_;      // of the last frame
  bool rests_ = false;            // the last frame changed nothing
  uint64_t rest_ticks_ = 1;       // interval of frames at rest; the same ticks for all clients
  grpc::ByteBuffer outgoing_;     // buffer of the current write
  bool writing_ = false;
  std::optional<grpc::Status> finish_when_flushed_;
  std::optional<grpc::Status> finish_status_;
  bool finished_ = false;
  bool done_ = false;
};

}  // namespace livegs
