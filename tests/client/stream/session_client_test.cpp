// SPDX-License-Identifier: Apache-2.0
// The client by itself, with a server that says what ours never would.
#include "stream/session_client.h"

#include <gtest/gtest.h>

#include <thread>

#include "client/stream/scripted_server.h"
#include "client/stream/sink_log.h"
#include "wire/frame_stream.h"

namespace livegs {
namespace {

ConnectOptions patient() {
  ConnectOptions options;
  options.timeout_s = options.reconnect_s = 60;
  return options;
}

v1::JoinReply welcome() {
  v1::JoinReply reply;
  reply.set_session_id("0123456789abcdef");
  reply.set_server_instance("one");
  reply.set_rate_hz(90);
  return reply;
}

// The server was replaced by one of another version while the client looked for it.
TEST(OtherVersion, EndsTheSessionWithItsAnswer) {
  ScriptedServer server;
  server.on_join = [](int before, const v1::JoinRequest&, v1::JoinReply& reply) {
    reply = welcome();
    return before == 0 ? grpc::Status::OK
                       : grpc::Status(grpc::StatusCode::FAILED_PRECONDITION, "speaks 5; update the older one");
  };
  server.on_stream = [](int, ScriptedServer::ServerStream&) { return grpc::Status(grpc::StatusCode::UNAVAILABLE, "going"); };
  server.start();
  auto joined = SessionClient::join(server.address(), patient());
  ASSERT_TRUE(joined) << joined.error().message;
  SinkLog sink;
  (*joined)->start(sink);
  while (!(*joined)->ended()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const auto stopped = (*joined)->stop();
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::Unsupported);
  EXPECT_NE(stopped.error().message.find("update the older one"), std::string::npos) << stopped.error().message;
}

// The first stream fails, as it does when a server goes between Join and Stream.
TEST(FirstStream, ThatFailsIsTriedAgain) {
  ScriptedServer server;
  std::vector<std::string> resumed;
  server.on_join = [&](int, const v1::JoinRequest& request, v1::JoinReply& reply) {
    resumed.push_back(request.resumed_session_id());
    reply = welcome();
    return grpc::Status::OK;
  };
  server.on_stream = [](int before, ScriptedServer::ServerStream& stream) {
    if (before < 2) return grpc::Status(grpc::StatusCode::UNAVAILABLE, "not yet");
    v1::ServerMessage message;
    DriverFrame frame;
    frame.tick = 7;
    message.set_tick(7);
    const auto encoded = encode_stream_frame(frame, nullptr);
    message.set_frame(encoded.bytes.data(), encoded.bytes.size());
    stream.Write(message);
    v1::ClientMessage incoming;
    while (stream.Read(&incoming)) {
    }
    return grpc::Status::OK;
  };
  server.start();
  auto joined = SessionClient::join(server.address(), patient());
  ASSERT_TRUE(joined) << joined.error().message;
  SinkLog sink;
  (*joined)->start(sink);
  EXPECT_TRUE(sink.wait([](const SinkLog::State& state) { return !state.frames.empty(); }));
  EXPECT_TRUE((*joined)->stop());
  EXPECT_EQ(resumed, (std::vector<std::string>{"", "0123456789abcdef", "0123456789abcdef"}));
}

// A frame whose bytes are not what was sent: refused, and a key frame asked for, which the stream goes on with.
TEST(SpoiledFrame, IsRefusedAndAKeyFrameIsAskedFor) {
  ScriptedServer server;
  server.on_join = [](int, const v1::JoinRequest&, v1::JoinReply& reply) {
    reply = welcome();
    return grpc::Status::OK;
  };
  server.on_stream = [](int, ScriptedServer::ServerStream& stream) {
    const auto send = [&](uint64_t tick, const EncodedStreamFrame& encoded, bool spoiled) {
      v1::ServerMessage message;
      message.set_tick(tick);
      std::string bytes(reinterpret_cast<const char*>(encoded.bytes.data()), encoded.bytes.size());
      if (spoiled) bytes.resize(bytes.size() - 1);
      message.set_frame(bytes);
      stream.Write(message);
    };
    DriverFrame frame;
    frame.objects.resize(1);
    frame.objects[0].object_id = 1;
    frame.objects[0].kind = DriverKind::Lattice;
    frame.objects[0].positions_m.assign(8, Eigen::Vector3f(0.25f, 0, 0));
    frame.tick = 1;
    EncodedStreamFrame encoded = encode_stream_frame(frame, nullptr);
    send(1, encoded, false);
    frame.tick = 2;
    frame.objects[0].positions_m.assign(8, Eigen::Vector3f(0.5f, 0.1f, 0));
    encoded = encode_stream_frame(frame, encoded.next);
    send(2, encoded, true);
    v1::ClientMessage incoming;
    while (stream.Read(&incoming)) {
      if (!incoming.key_frame_wanted()) continue;
      frame.tick = 3;
      send(3, encode_stream_frame(frame, nullptr), false);
    }
    return grpc::Status::OK;
  };
  server.start();
  auto joined = SessionClient::join(server.address(), patient());
  ASSERT_TRUE(joined) << joined.error().message;
  SinkLog sink;
  (*joined)->start(sink);
  EXPECT_TRUE(sink.wait([](const SinkLog::State& state) { return state.frames.size() >= 2; }));
  EXPECT_TRUE((*joined)->stop());
  const SinkLog::State state = sink.state();
  EXPECT_EQ(state.frames[0].tick, 1u);
  EXPECT_EQ(state.frames[1].tick, 3u);
  EXPECT_TRUE(state.lost.empty());
}

}  // namespace
}  // namespace livegs
