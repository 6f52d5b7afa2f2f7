// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/stream_call.h"

#include <grpcpp/impl/codegen/proto_buffer_reader.h>

#include <algorithm>

#include "core/clock.h"
#include "core/log.h"
#include "session/frame_tail.h"
#include "session/grpc_status.h"
#include "session/input_check.h"

namespace livegs {
namespace {

void write_floats(google::protobuf::RepeatedField<float>& out, const Eigen::Vector3d& value) {
  for (int i = 0; i < 3; ++i) out.Add(static_cast<float>(value[i]));
}

// Everything of a message but its frame.
v1::ServerMessage header_of(const SendWindow::Outgoing& outgoing, SessionNumber session, int64_t echoed_ns) {
  v1::ServerMessage header;
  header.set_sent_ns(now_ns());
  header.set_echoed_ns(echoed_ns);
  for (const v1::SessionEvent& event : outgoing.events) *header.add_events() = event;
  if (!outgoing.tick) return header;
  const PublishedTick& tick = *outgoing.tick;
  header.set_tick(tick.tick());
  header.set_stepped_ns(tick.stepped_ns);
  header.set_step_ms(tick.step_ms);
  const auto own = std::lower_bound(
      tick.hands.begin(), tick.hands.end(), session,
      [](const SessionHands& hands, SessionNumber number) { return hands.session < number; });
  if (own == tick.hands.end() || own->session != session) return header;
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

}  // namespace

StreamCall* StreamCall::start(SessionTable& table, grpc::CallbackServerContext& context) {
  const std::shared_ptr<StreamCall> call(new StreamCall(table, context));
  call->self_ = call;
  call->StartRead(&call->incoming_);
  return call.get();
}

void StreamCall::OnReadDone(bool ok) {
  if (!ok) {  // the client is done, or gone
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
      return grpc::Status(grpc::StatusCode::INVALID_ARGUMENT, "the message is no livegs.v1.ClientMessage");
    }
  }
  std::shared_ptr<ClientSession> session;
  {
    std::lock_guard lock(mutex_);
    session = session_;
  }
  if (!session) {
    session = table_.find(message.session_id());
    if (!session) {
      return grpc::Status(grpc::StatusCode::NOT_FOUND, "session_id: no such session; call Join first");
    }
    if (!session->attach(weak_from_this())) {
      return grpc::Status(grpc::StatusCode::ALREADY_EXISTS, "session_id: the session has a stream already");
    }
    log_info("session %.8s: streaming to %s", session->id.c_str(), context_.peer().c_str());
    std::lock_guard lock(mutex_);
    session_ = session;
  }
  auto samples = check_inputs(message);
  if (!samples) return to_status(samples.error());
  session->heard_ns = now_ns();
  echoed_ns_ = message.sent_ns();
  session->acknowledge(message.acknowledged_tick());
  if (message.key_frame_wanted()) {
    std::lock_guard lock(mutex_);
    baseline_ = nullptr;
  }
  table_.hear(*session, *samples);
  return std::nullopt;
}

void StreamCall::wake() {
  std::lock_guard lock(mutex_);
  write_next(lock);
}

void StreamCall::write_next(const std::lock_guard<std::mutex>& lock) {
  if (writing_ || finish_status_ || !session_) return;
  const auto outgoing = session_->take();
  if (!outgoing) {
    if (!finish_when_flushed_) return;
    finish_status_ = finish_when_flushed_;
    finish_if_idle(lock);
    return;
  }
  std::string header;
  header_of(*outgoing, session_->number, echoed_ns_).SerializeToString(&header);
  std::vector<grpc::Slice> slices{grpc::Slice(header)};
  if (outgoing->tick) {
    const EncodedFrame frame = outgoing->tick->against(baseline_);
    baseline_ = frame.next;
    slices.push_back(frame.tail->slice);  // counted, not copied
  }
  outgoing_ = grpc::ByteBuffer(slices.data(), slices.size());
  writing_ = true;
  StartWrite(&outgoing_);
}

void StreamCall::OnWriteDone(bool ok) {
  std::lock_guard lock(mutex_);
  writing_ = false;
  if (!ok && !finish_status_)
    finish_status_ = grpc::Status(grpc::StatusCode::CANCELLED, "the client is gone");
  if (finish_status_)
    finish_if_idle(lock);
  else
    write_next(lock);
}

void StreamCall::OnCancel() { request_finish(grpc::Status::CANCELLED); }

void StreamCall::request_finish(const grpc::Status& status) {
  std::lock_guard lock(mutex_);
  // A client that hangs up on hearing the farewell is still told why.
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

void StreamCall::abort() {
  std::lock_guard lock(mutex_);
  if (!done_) context_.TryCancel();  // also ends a write that the client does not read
}

void StreamCall::OnDone() {
  std::shared_ptr<ClientSession> session;
  {
    std::lock_guard lock(mutex_);
    done_ = true;
    session = session_;
  }
  if (session) {
    table_.remove(*session);
    log_info("session %.8s: ended, %llu frames sent, %llu replaced by newer ones", session->id.c_str(),
             static_cast<unsigned long long>(session->frames_sent()),
             static_cast<unsigned long long>(session->frames_replaced()));
  }
  const std::shared_ptr<StreamCall> last_share = std::move(self_);
}

}  // namespace livegs
