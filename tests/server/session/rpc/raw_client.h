// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <grpcpp/create_channel.h>
#include <gtest/gtest.h>

#include <chrono>

#include "livegs/v1/session.grpc.pb.h"
#include "server/session/simulation/tick_log.h"
#include "wire/frame_codec.h"

namespace livegs {

inline std::shared_ptr<grpc::Channel> channel_to(int port) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  return grpc::CreateCustomChannel("127.0.0.1:" + std::to_string(port), grpc::InsecureChannelCredentials(),
                                   arguments);
}

inline void set_patience(grpc::ClientContext& context) {
  context.set_deadline(std::chrono::system_clock::now() + kPatience);
}

// A client whose messages are fully controlled by the test.
class RawClient {
 public:
  explicit RawClient(int port) : RawClient(channel_to(port)) {}
  explicit RawClient(const std::shared_ptr<grpc::Channel>& channel) : stub_(v1::LiveGs::NewStub(channel)) {}
  v1::LiveGs::Stub& stub() { return *stub_; }

  grpc::Status join(uint32_t protocol_version = kProtocolVersion,
                    const std::string& resumed_session_id = "") {
    grpc::ClientContext context;
    set_patience(context);
    v1::JoinRequest request;
    request.set_protocol_version(protocol_version);
    request.set_client_name("a test");
    request.set_resumed_session_id(resumed_session_id);
    request.set_position_bits(position_bits);
    request.set_encoding(encoding);
    return stub_->Join(&context, request, &joined);
  }
  // May be called again after finish() has returned.
  void open() {
    open_silently();
    v1::ClientMessage message;
    message.set_session_id(joined.session_id());
    EXPECT_TRUE(stream_->Write(message));
  }
  // Opens a stream without sending the session id.
  void open_silently() {
    context_ = std::make_unique<grpc::ClientContext>();
    set_patience(*context_);
    stream_ = stub_->Stream(context_.get());
  }
  bool send(const v1::ClientMessage& message) { return stream_->Write(message); }
  bool acknowledge(uint64_t tick) {
    v1::ClientMessage message;
    message.set_acknowledged_tick(tick);
    return send(message);
  }
  // The next message that is not a keepalive; a message without a tick when the stream has ended.
  v1::ServerMessage read() {
    v1::ServerMessage message;
    while (read_any(message)) {
      if (!message.frame().empty() || message.events_size() > 0) return message;
    }
    return {};
  }
  bool read_any(v1::ServerMessage& message) { return stream_->Read(&message); }
  grpc::Status finish() {
    stream_->WritesDone();
    v1::ServerMessage message;
    while (stream_->Read(&message)) {
    }
    return stream_->Finish();
  }
  // Like finish(), without closing this side first.
  grpc::Status finish_reading() {
    v1::ServerMessage message;
    while (stream_->Read(&message)) {
    }
    return stream_->Finish();
  }
  void cancel() { context_->TryCancel(); }

  uint32_t position_bits = 0;  // requested at Join, like the next
  v1::JoinRequest::Encoding encoding = v1::JoinRequest::DRIVERS;
  v1::JoinReply joined;

 private:
  std::unique_ptr<v1::LiveGs::Stub> stub_;
  std::unique_ptr<grpc::ClientContext> context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::ClientMessage, v1::ServerMessage>> stream_;
};

}  // namespace livegs
