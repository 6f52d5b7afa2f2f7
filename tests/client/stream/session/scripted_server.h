// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>
#include <gtest/gtest.h>

#include <functional>
#include <memory>

#include "livegs/v1/session.grpc.pb.h"

namespace livegs {

// A server whose replies are set by a test, including replies the real server never sends.
class ScriptedServer final : private v1::LiveGs::Service {
 public:
  using ServerStream = grpc::ServerReaderWriter<v1::ServerMessage, v1::ClientMessage>;
  // The first argument counts the previous calls.
  std::function<grpc::Status(int, const v1::JoinRequest&, v1::JoinReply&)> on_join;
  std::function<grpc::Status(int, ServerStream&)> on_stream;

  void start() {
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port_);
    builder.RegisterService(this);
    server_ = builder.BuildAndStart();
    ASSERT_NE(server_, nullptr);
  }
  ~ScriptedServer() override {
    if (server_) server_->Shutdown(std::chrono::system_clock::now());
  }
  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

 private:
  grpc::Status Join(grpc::ServerContext*, const v1::JoinRequest* request, v1::JoinReply* reply) override {
    return on_join(joins_++, *request, *reply);
  }
  grpc::Status Stream(grpc::ServerContext*, ServerStream* stream) override {
    return on_stream(streams_++, *stream);
  }
  std::atomic<int> joins_{0}, streams_{0};
  int port_ = 0;
  std::unique_ptr<grpc::Server> server_;
};

}  // namespace livegs
