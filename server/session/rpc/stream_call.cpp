// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/rpc/stream_call.h"

#include <grpcpp/impl/codegen/proto_buffer_reader.h>

#include <algorithm>
#include <new>

#include "core/clock.h"
#include "core/log.h"
#include "session/frames/shared_frame_payload.h"
#include "session/rpc/grpc_status.h"
#include "session/simulation/input_check.h"
#include "session/tick/run_control.h"

namespace livegs {
namespace {

void write_floats(google::protobuf::RepeatedField<float>& out, const Eigen::Vector3d& value) {
  for (int i = 0; i < 3; ++i) out.Add(static_cast<float>(value[i]));
}

// The hands of a session in a tick; null if it has none.
const SessionHands* hands_of(const TickEncodings& tick, SessionNumber session) {
  const auto own = std::lower_bound(
      tick.hands.begin(), tick.hands.end(), session,
      [](const SessionHands& hands, SessionNumber number) { return hands.session < number; });
  return own == tick.hands.end() || own->session != session ? nullptr : &*own;
}

std::vector<uint32_t> held_by(const SessionHands* hands) {
  std::vector<uint32_t> held;
  if (!hands) return held;
  for (const HeldPoint& point : hands->hands) {
    if (point.holding) held.push_back(point.object_id);
  }
  std::sort(held.begin(), held.end());
  return held;
}

// The message without the frame, the send times and the echoed times.
v1::ServerMessage header_of(const SendWindow::Outgoing& outgoing, SessionNumber session) {
  v1::ServerMessage header;
  for (const v1::SessionEvent& event : outgoing.events) *header.add_events() = event;
  if (!outgoing.tick) return header;
  const TickEncodings& tick = *outgoing.tick;
  header.set_tick(tick.tick());
  header.set_stepped_ns(tick.stepped_ns);
  header.set_step_ms(tick.step_ms);
  write_run(tick.run, *header.mutable_run());
  const SessionHands* const own = hands_of(tick, session);
  if (!own) return header;
  header.set_input_sequence(own->input_sequence);
  for (uint32_t i = 0; i < own->hands.size(); ++i) {
    const HeldPoint& held = own->hands[i];
    if (!held.holding) continue;
    v1::HandState& hand = *header.add_hands();
    hand.set_hand(i);
    hand.set_object_id(held.object_id);
    write_floats(*hand.mutable_point_m(), held.point_m);
    write_floats(*hand.mutable_force_n(), held.force_n);
    hand.set_grabbed(held.grabbed);
    if (held.grabbed) write_floats(*hand.mutable_torque_n_m(), held.torque_n_m);
    hand.set_contact_impulse_n_s(static_cast<float>(held.contact_impulse_n_s));
  }
  return header;
}

// Serialised header of a frame without its times.
std::string contents_of(v1::ServerMessage header) {
  header.clear_tick();
  header.clear_stepped_ns();
  header.clear_step_ms();
  header.clear_encode_begun_ns();
  header.mutable_run()->clear_simulated_s();
  return header.SerializeAsString();
}

}  // namespace

StreamCall* StreamCall::start(SessionTable& table, Result<Authorization> authorization,
                              grpc::CallbackServerContext& context) {
  const std::shared_ptr<StreamCall> call(
      new StreamCall(table, authorization ? *authorization : Authorization{}, context));
  call->self_ = call;
  if (authorization) {
    table.stream_begun(call);
    call->StartRead(&call->incoming_);
  } else {
    call->request_finish(to_status(authorization.error()));
  }
  return call.get();
}

void StreamCall::OnReadDone(bool ok) {
  if (!ok) {  // the client closed its side or disconnected
    request_finish(grpc::Status::OK);
    return;
  }
  if (const auto refused = take_message()) {
    request_finish(*refused);
    return;
  }
  wake();
  std::lock_guard lock(mutex_);
  if (!finish_status_) StartRead(&incoming_);
}

std::optional<grpc::Status> StreamCall::take_message() {
  v1::ClientMessage message;
  {
    grpc::ProtoBufferReader reader(&incoming_);
    if (!reader.status().ok() || !message.ParseFromZeroCopyStream(&reader)) {
      return grpc::Status(grpc::StatusCode::INVALID_ARGUMENT,
                          "message: is not a livegs.v1.ClientMessage; update the client");
    }
  }
  const int64_t received_ns = now_ns();
  std::shared_ptr<ClientSession> session;
  uint64_t stream = 0;
  {
    std::lock_guard lock(mutex_);
    if (!messages_.try_take(received_ns)) {
      return grpc::Status(grpc::StatusCode::RESOURCE_EXHAUSTED,
                          "messages: more than 1000 a second; send fewer");
    }
    session = session_;
    stream = stream_;
  }
  if (!session) {
    session = table_.find(message.session_id());
    if (!session || session->who.authorization.token_id != authorization_.token_id) {
      return grpc::Status(grpc::StatusCode::NOT_FOUND, "session_id: is not a session; call Join first");
    }
    const auto attached = session->attach(weak_from_this());
    if (!attached) {
      return session->state() == ClientSession::State::Streaming
                 ? grpc::Status(grpc::StatusCode::ALREADY_EXISTS,
                                "session_id: the session already has a stream")
                 : grpc::Status(grpc::StatusCode::NOT_FOUND,
                                "session_id: the session is parked; call Join with resumed_session_id first");
    }
    stream = attached->stream;
    log_info("session %.8s: streaming to %s", session->id.c_str(), context_.peer().c_str());
    {
      std::lock_guard lock(mutex_);
      session_ = session;
      stream_ = stream;
      position_bits_ = attached->terms.position_bits;
      encoding_ = attached->terms.encoding;
      rest_ticks_ = std::max<uint64_t>(1, static_cast<uint64_t>(kRestInterval_ns / attached->terms.tick_ns));
    }
    table_.stream_attached(*session, *this);
  }
  auto samples = check_inputs(message);
  if (!samples) return to_status(samples.error());
  const auto view = check_view(message);
  if (!view) return to_status(view.error());
  if (!session->acknowledge(stream, message.acknowledged_tick(), received_ns)) {
    return grpc::Status(grpc::StatusCode::ABORTED, "session: continues in another stream");
  }
  session->last_message_ns = received_ns;
  {
    std::lock_guard lock(mutex_);
    echoed_ns_ = message.sent_ns();
    received_ns_ = received_ns;
    if (*view) view_ = *view;
    if (message.key_frame_wanted()) baseline_ = nullptr;
    for (; !unacknowledged_.empty() && unacknowledged_.front().tick <= message.acknowledged_tick();
         unacknowledged_.pop_front()) {
      if (const Written& frame = unacknowledged_.front(); frame.tick == message.acknowledged_tick()) {
        session->add_answer(milliseconds_from_ns(received_ns - frame.written_ns),
                            milliseconds_from_ns(received_ns - frame.stepped_ns));
      }
    }
  }
  table_.on_input(*session, *samples);  // drops the samples of a token without INTERACT
  return std::nullopt;
}

void StreamCall::wake() {
  std::lock_guard lock(mutex_);
  write_next(lock);
}

void StreamCall::write_next(const std::lock_guard<std::mutex>& lock) {
  if (writing_ || finish_status_ || !session_) return;
  const int64_t now = now_ns();
  while (const auto outgoing = session_->take(stream_, now, session_->budget->available_bytes(now) > 0)) {
    if (write(*outgoing, lock)) return;
  }
  if (finish_when_flushed_) {
    finish_status_ = finish_when_flushed_;
    finish_if_idle(lock);
  }
}

void StreamCall::send_keepalive(int64_t now) {
  std::lock_guard lock(mutex_);
  if (writing_ || finish_status_ || !session_ || now - written_ns_ < kKeepaliveInterval_ns) return;
  write({}, lock);
}

bool StreamCall::write(const SendWindow::Outgoing& outgoing, const std::lock_guard<std::mutex>&) {
  v1::ServerMessage header = header_of(outgoing, session_->number);
  std::vector<grpc::Slice> slices(1);
  if (outgoing.tick) {
    header.set_encode_begun_ns(now_ns());
    const TickEncodings& tick = *outgoing.tick;
    const ClientView who{view_, held_by(hands_of(tick, session_->number)), position_bits_,
                         !session_->budget->capped() && !outgoing.slow};
    const EncodedFrame frame =
        encoding_ == v1::JoinRequest::DRIVERS
            ? tick.for_client(baseline_, who, session_->budget->available_bytes(now_ns()))
            : tick.keyframe(encoding_);
    // Two frames without a change are written, so that the client can see that the scene rests.
    const bool unchanged =
        frame.unchanged && outgoing.events.empty() && contents_of(header) == contents_of(header_);
    // Ticks of a slow simulation are farther apart.
    const bool soon = now_ns() - written_ns_ < kRestInterval_ns;
    if (unchanged && rests_ && soon && tick.tick() / rest_ticks_ == header_.tick() / rest_ticks_) {
      session_->withdraw(stream_, tick.tick());
      return false;
    }
    rests_ = unchanged;
    header_ = header;
    header_.clear_events();
    baseline_ = frame.next;
    slices.push_back(frame.tail->slice);  // shared, not copied
  }
  written_ns_ = now_ns();
  if (outgoing.tick)
    unacknowledged_.push_back({outgoing.tick->tick(), outgoing.tick->stepped_ns, written_ns_});
  header.set_sent_ns(written_ns_);
  header.set_echoed_ns(echoed_ns_);
  header.set_received_ns(received_ns_);
  slices.front() = grpc::Slice(header.SerializeAsString());
  outgoing_ = grpc::ByteBuffer(slices.data(), slices.size());
  session_->bytes_sent += outgoing_.Length();
  session_->budget->pay(static_cast<double>(outgoing_.Length()));
  writing_ = true;
  StartWrite(&outgoing_);
  return true;
}

void StreamCall::OnWriteDone(bool ok) {
  std::lock_guard lock(mutex_);
  writing_ = false;
  if (ok) session_->add_send(milliseconds_from_ns(now_ns() - written_ns_));
  if (!ok && !finish_status_)
    finish_status_ = grpc::Status(grpc::StatusCode::CANCELLED, "the client disconnected");
  if (finish_status_)
    finish_if_idle(lock);
  else
    write_next(lock);
}

void StreamCall::OnCancel() { request_finish(grpc::Status::CANCELLED); }

void StreamCall::request_finish(const grpc::Status& status) {
  std::lock_guard lock(mutex_);
  // A client that hangs up after the draining event still gets the reason.
  if (!finish_status_) finish_status_ = status.ok() && finish_when_flushed_ ? *finish_when_flushed_ : status;
  finish_if_idle(lock);
}

void StreamCall::finish_if_idle(const std::lock_guard<std::mutex>&) {
  if (writing_ || finished_) return;
  finished_ = true;
  Finish(*finish_status_);
}

void StreamCall::close(const std::string& reason) {
  std::lock_guard lock(mutex_);
  finish_when_flushed_ = grpc::Status(grpc::StatusCode::UNAVAILABLE, reason);
  write_next(lock);
}

void StreamCall::end(const Error& why) { request_finish(to_status(why)); }

void StreamCall::end_without_session() {
  std::lock_guard lock(mutex_);
  if (session_ || finish_status_) return;
  finish_status_ = grpc::Status(grpc::StatusCode::DEADLINE_EXCEEDED,
                                "stream: no message within 2 s; send the session_id first");
  finish_if_idle(lock);
}

void StreamCall::abort() {
  std::lock_guard lock(mutex_);
  if (!done_) context_.TryCancel();  // also aborts a write that the client does not read
}

void StreamCall::OnDone() {
  std::shared_ptr<ClientSession> session;
  uint64_t stream = 0;
  bool in_order = false;
  {
    std::lock_guard lock(mutex_);
    done_ = true;
    session = session_;
    stream = stream_;
    // A refused message ends the session. A vanished client keeps its session: it did not receive the status.
    const bool refused = finish_status_ && finish_status_->error_code() == grpc::StatusCode::INVALID_ARGUMENT;
    const bool complete = finish_status_ && (finish_status_->ok() || finish_when_flushed_);
    in_order = refused || (complete && !context_.IsCancelled());
  }
  if (session) {
    table_.stream_ended(*session, stream, in_order);
    log_info("session %.8s: stream %s, %llu frames sent, %llu dropped because newer ones waited",
             session->id.c_str(), in_order ? "ended" : "broke",
             static_cast<unsigned long long>(session->frames_sent()),
             static_cast<unsigned long long>(session->frames_replaced()));
  }
  const std::shared_ptr<StreamCall> last_share = std::move(self_);
}

}  // namespace livegs
