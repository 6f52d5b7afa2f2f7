// SPDX-License-Identifier: Apache-2.0
#include "stream/session/session_stream.h"

#include <pthread.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "core/clock.h"
#include "core/log.h"
#include "core/text/format_text.h"
#include "stream/session/input_message.h"

namespace livegs {
namespace {

constexpr std::chrono::milliseconds kKeepaliveInterval{50};
constexpr std::chrono::milliseconds kPollInterval{50};  // check for a silent server
constexpr int64_t kSilenceGapFactor = 5;  // multiple of the longest gap between frames of kernels
constexpr int64_t kHalfCloseTimeout_ns = 1'000'000'000;
// Samples in a message: the last three, so that a lost message loses no press, or all that are new, up to the
// maximum that a server accepts. Older than the last kMaxUnsentSamples are dropped if the stream stalls.
constexpr size_t kSamplesPerMessage = 3, kMaxSamplesPerMessage = 8, kMaxUnsentSamples = 64;
// Between requests for a keyframe: the requested one may be damaged too.
constexpr int64_t kKeyframeRetryInterval_ns = 250'000'000;

Eigen::Vector3f vector_of(const google::protobuf::RepeatedField<float>& numbers) {
  return numbers.size() == 3 ? Eigen::Vector3f(numbers[0], numbers[1], numbers[2]) : Eigen::Vector3f::Zero();
}

// The first frame of a stream is excluded: it waits for the client to be ready.
constexpr double kLateKernelFrame_ms = 150;
constexpr size_t kMaxLateKernelFrames = 3;

}  // namespace

SessionStream::SessionStream(v1::LiveGs::Stub& stub, std::string session_id, double rate_hz,
                             v1::JoinRequest::Encoding encoding, int64_t first_silence_ns, Ends ends)
    : stub_(stub),
      session_id_(std::move(session_id)),
      ends_(ends),
      first_silence_ns_(first_silence_ns),
      frames_(encoding),
      streams_kernels_(FrameReader::is_kernel_encoding(encoding)),
      aim_(rate_hz) {}

SessionStream::Outcome SessionStream::run() {
  last_message_ns_ = now_ns();
  stream_ = stub_.Stream(&context_);
  std::thread writer([this] {
    pthread_setname_np(pthread_self(), "stream writer");
    write();
  });
  std::thread reader([this] {
    pthread_setname_np(pthread_self(), "stream reader");
    read();
  });
  {
    std::unique_lock lock(mutex_);
    int64_t stopping_ns = 0;
    while (!ended_) {
      over_.wait_for(lock, kPollInterval, [&] { return ended_; });
      const int64_t now = now_ns();
      if (stopping_ && stopping_ns == 0) stopping_ns = now;
      const int64_t most_ns = longest_silence_ns();
      const bool silent = now - last_message_ns_ > most_ns;
      if (silent && !outcome_.silent) {
        outcome_.silent = true;
        outcome_.reason = most_ns <= kServerTimeout_ns
                              ? "no message for 1 s"
                              : format_text("no message for %.1f s", seconds_from_ns(most_ns));
        if (streams_kernels_ && outcome_.frames == 0)
          outcome_.reason += ", frames of kernels may be too large for the link";
      }
      if (silent || (stopping_ns != 0 && now - stopping_ns > kHalfCloseTimeout_ns)) context_.TryCancel();
    }
  }
  writer.join();
  reader.join();
  outcome_.last_message_ns = last_message_ns_;
  if (outcome_.reason.empty()) outcome_.reason = outcome_.status.error_message();
  if (outcome_.reason.empty()) outcome_.reason = "the stream ended";
  return std::move(outcome_);
}

int64_t SessionStream::longest_silence_ns() const {
  if (outcome_.frames == 0) return first_silence_ns_;
  return streams_kernels_ ? std::clamp(kSilenceGapFactor * longest_gap_ns_, kServerTimeout_ns, kMaxSilence_ns)
                          : kServerTimeout_ns;
}

void SessionStream::send(const InputSample& sample) {
  {
    std::lock_guard lock(mutex_);
    samples_.push_back(sample);
    samples_.back().for_tick = aim_.tick_at(now_ns());
    unsent_samples_ = std::min(unsent_samples_ + 1, kMaxUnsentSamples);
    while (samples_.size() > std::max(kSamplesPerMessage, unsent_samples_)) samples_.pop_front();
  }
  to_send_.notify_one();
}

void SessionStream::set_view(const ViewCone& view) {
  std::lock_guard lock(mutex_);
  view_ = view;
}

void SessionStream::stop() {
  {
    std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  to_send_.notify_one();
}

void SessionStream::write() {
  v1::ClientMessage message;
  message.set_session_id(session_id_);  // required in the first message only
  for (bool first = true;; first = false) {
    {
      std::unique_lock lock(mutex_);
      if (!first) {
        to_send_.wait_for(lock, kKeepaliveInterval,
                          [&] { return stopping_ || ended_ || unsent_samples_ > 0 || acknowledgement_new_; });
      }
      if (stopping_ || ended_) break;
      acknowledgement_new_ = false;
      message.set_acknowledged_tick(acknowledged_tick_);
      message.set_key_frame_wanted(std::exchange(keyframe_wanted_, false));
      const size_t begin =
          samples_.size() - std::min(samples_.size(), std::max(kSamplesPerMessage, unsent_samples_));
      const size_t end = std::min(samples_.size(), begin + kMaxSamplesPerMessage);
      for (size_t i = begin; i < end; ++i) write_input(samples_[i], *message.add_inputs());
      unsent_samples_ = samples_.size() - end;
      if (view_) write_view(*view_, *message.mutable_view());
      view_.reset();
    }
    message.set_sent_ns(now_ns());
    if (!stream_->Write(message)) break;
    message.Clear();
  }
  stream_->WritesDone();
}

void SessionStream::read() {
  v1::ServerMessage message;
  Result<void> taken;
  while (stream_->Read(&message)) {
    const int64_t received_ns = now_ns();
    longest_gap_ns_ = std::max<int64_t>(longest_gap_ns_, received_ns - last_message_ns_);
    last_message_ns_ = received_ns;
    taken = take(message, received_ns);
    if (!taken) {
      context_.TryCancel();
      break;
    }
  }
  const grpc::Status status = stream_->Finish();
  {
    std::lock_guard lock(mutex_);
    outcome_.status = status;
    if (!taken) outcome_.error = taken.error();
    ended_ = true;
  }
  over_.notify_one();
  to_send_.notify_one();
}

Result<void> SessionStream::take(const v1::SessionEvent& event) {
  switch (event.kind_case()) {
    case v1::SessionEvent::kObjectAdded:
    case v1::SessionEvent::kObjectChanged: {
      const bool added = event.has_object_added();
      auto object = ends_.objects.take(added ? event.object_added() : event.object_changed());
      if (!object) return object.error();
      added ? ends_.sink.on_object_added(std::move(*object))
            : ends_.sink.on_object_changed(std::move(*object));
      break;
    }
    case v1::SessionEvent::kObjectRemoved:
      ends_.objects.remove(event.object_removed().object_id());
      ends_.sink.on_object_removed(event.object_removed().object_id());
      break;
    case v1::SessionEvent::kDraining: {
      const bool moves = !event.next_server().address().empty();
      {
        std::lock_guard lock(mutex_);
        outcome_.drained = !moves;
        if (moves) outcome_.next_server = event.next_server();
      }
      moves ? ends_.sink.on_moving(event.draining(), event.next_server().address())
            : ends_.sink.on_draining(event.draining());
      break;
    }
    case v1::SessionEvent::KIND_NOT_SET:
      break;  // an event of a later protocol version, which can be ignored
  }
  return {};
}

void SessionStream::take_clock(const v1::ServerMessage& message, int64_t received_ns) {
  if (message.echoed_ns() <= echoed_ns_ || message.received_ns() == 0) return;  // already processed
  echoed_ns_ = message.echoed_ns();
  ends_.clock.add({echoed_ns_, message.received_ns(), message.sent_ns(), received_ns});
  std::lock_guard lock(mutex_);
  aim_.arrived(echoed_ns_, message.received_ns());
}

void SessionStream::warn_of_late_kernels(const ReceivedFrame& frame) {
  if (!streams_kernels_ || warned_ || !frame.clock) return;
  const double age_ms = milliseconds_from_ns(frame.decoded_ns + frame.clock->offset_ns - frame.stepped_ns);
  late_kernel_frames_ = age_ms > kLateKernelFrame_ms ? late_kernel_frames_ + 1 : 0;
  if (late_kernel_frames_ < kMaxLateKernelFrames) return;
  warned_ = true;
  log_warn(
      "frames of kernels are %.0f ms late: transforming, packing and sending %.1f MB exceeds the tick "
      "period; use --encoding drivers",
      age_ms, 1e-6 * static_cast<double>(frame.bytes));
}

Result<void> SessionStream::take(v1::ServerMessage& message, int64_t received_ns) {
  take_clock(message, received_ns);
  for (const v1::SessionEvent& event : message.events()) {
    if (auto taken = take(event); !taken) return taken;
  }
  if (message.frame().empty()) return {};
  ReceivedFrame frame;
  frame.tick = message.tick();
  frame.stepped_ns = message.stepped_ns();
  frame.encode_begun_ns = message.encode_begun_ns();
  frame.sent_ns = message.sent_ns();
  frame.received_ns = received_ns;
  frame.clock = ends_.clock.at(received_ns);
  frame.step_ms = message.step_ms();
  frame.input_sequence = message.input_sequence();
  frame.run = message.run();
  for (const v1::HandState& hand : message.hands()) {
    frame.hands.push_back({hand.hand(), hand.object_id(), vector_of(hand.point_m()),
                           vector_of(hand.force_n()), hand.grabbed(), hand.contact_impulse_n_s()});
  }
  {
    std::lock_guard lock(mutex_);
    aim_.add_frame(frame.tick, frame.stepped_ns - static_cast<int64_t>(1e6 * frame.step_ms));
  }
  const uint64_t tick = frame.tick;
  const bool waits =
      frames_.needs_keyframe() && received_ns - keyframe_requested_ns_ < kKeyframeRetryInterval_ns;
  auto drivers = frames_.read(std::as_bytes(std::span(message.frame())));
  if (drivers) {
    frame.bytes = message.frame().size();
    frame.drivers = std::make_shared<const DriverFrame>(std::move(*drivers));
    frame.decoded_ns = now_ns();
    warn_of_late_kernels(frame);
    ends_.sink.on_frame(std::move(frame));
  } else {
    log_debug("frame %llu: %s", static_cast<unsigned long long>(tick), drivers.error().message.c_str());
  }
  {
    std::lock_guard lock(mutex_);
    outcome_.frames += drivers ? 1 : 0;
    if (!drivers && !waits) {
      keyframe_wanted_ = true;
      keyframe_requested_ns_ = received_ns;
    }
    acknowledged_tick_ = tick;
    acknowledgement_new_ = true;
  }
  to_send_.notify_one();
  return {};
}

}  // namespace livegs
