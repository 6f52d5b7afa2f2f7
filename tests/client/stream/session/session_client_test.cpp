// SPDX-License-Identifier: Apache-2.0
// The client against a server with replies that the real server never sends.
#include "stream/session/session_client.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

#include "client/stream/session/scripted_server.h"
#include "client/stream/session/sink_log.h"
#include "core/clock.h"
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
grpc::Status let_in(int, const v1::JoinRequest&, v1::JoinReply& reply) {
  reply = welcome();
  return grpc::Status::OK;
}

// `spoiled`: without the last byte.
void send(ScriptedServer::ServerStream& stream, uint64_t tick, const EncodedStreamFrame& encoded,
          bool spoiled = false) {
  v1::ServerMessage message;
  message.set_tick(tick);
  message.set_frame(encoded.bytes.data(), encoded.bytes.size() - (spoiled ? 1 : 0));
  stream.Write(message);
}
DriverFrame frame_of_a_lattice() {
  DriverFrame frame;
  frame.objects.resize(1);
  frame.objects[0].object_id = 1;
  frame.objects[0].kind = DriverKind::Lattice;
  frame.objects[0].positions_m.assign(8, Eigen::Vector3f(0.25f, 0, 0));
  return frame;
}

// The server was replaced by another version while the client reconnects.
TEST(OtherVersion, EndsSessionWithServerError) {
  ScriptedServer server;
  server.on_join = [](int before, const v1::JoinRequest&, v1::JoinReply& reply) {
    reply = welcome();
    return before == 0
               ? grpc::Status::OK
               : grpc::Status(grpc::StatusCode::FAILED_PRECONDITION, "speaks 5; update the older one");
  };
  server.on_stream = [](int, ScriptedServer::ServerStream&) {
    return grpc::Status(grpc::StatusCode::UNAVAILABLE, "going");
  };
  server.start();
  auto joined = SessionClient::join(server.address(), patient());
  ASSERT_TRUE(joined) << joined.error().message;
  SinkLog sink;
  (*joined)->start(sink);
  while (!(*joined)->ended()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const auto stopped = (*joined)->stop();
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::Unsupported);
  EXPECT_NE(stopped.error().message.find("update the older one"), std::string::npos)
      << stopped.error().message;
}

// The first stream fails, as when a server stops between Join and Stream.
TEST(FirstStream, FailureIsRetried) {
  ScriptedServer server;
  std::vector<std::string> resumed;
  server.on_join = [&](int, const v1::JoinRequest& request, v1::JoinReply& reply) {
    resumed.push_back(request.resumed_session_id());
    reply = welcome();
    return grpc::Status::OK;
  };
  server.on_stream = [](int before, ScriptedServer::ServerStream& stream) {
    if (before < 2) return grpc::Status(grpc::StatusCode::UNAVAILABLE, "not yet");
    DriverFrame frame;
    frame.tick = 7;
    send(stream, 7, encode_stream_frame(frame, nullptr));
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

// Frames of kernels are too large for the link: each stream gets more time, and after three the session ends
// with the remedy.
TEST(SilentStream, OfKernelsEndsSessionWithRemedy) {
  ScriptedServer server;
  server.on_join = [](int, const v1::JoinRequest& request, v1::JoinReply& reply) {
    reply = welcome();
    reply.set_encoding(request.encoding());
    return grpc::Status::OK;
  };
  std::mutex mutex;
  std::vector<double> lasted_s;
  server.on_stream = [&](int, ScriptedServer::ServerStream& stream) {
    const int64_t begun_ns = now_ns();
    v1::ClientMessage incoming;
    while (stream.Read(&incoming)) {
    }
    std::lock_guard lock(mutex);
    lasted_s.push_back(seconds_from_ns(now_ns() - begun_ns));
    return grpc::Status::OK;
  };
  server.start();
  ConnectOptions options = patient();
  options.encoding = v1::JoinRequest::KERNELS;
  options.first_kernels_s = 0.2;
  auto joined = SessionClient::join(server.address(), options);
  ASSERT_TRUE(joined) << joined.error().message;
  SinkLog sink;
  (*joined)->start(sink);
  while (!(*joined)->ended()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const auto stopped = (*joined)->stop();
  ASSERT_FALSE(stopped);
  EXPECT_NE(stopped.error().message.find("--encoding drivers"), std::string::npos) << stopped.error().message;
  const SinkLog::State state = sink.state();
  ASSERT_EQ(state.lost.size(), 2u);
  EXPECT_NE(state.lost.front().find("too large for the link"), std::string::npos) << state.lost.front();
  for (int i = 0; i < 1000; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    std::lock_guard lock(mutex);
    if (lasted_s.size() == 3) break;
  }
  std::lock_guard lock(mutex);
  ASSERT_EQ(lasted_s.size(), 3u);
  for (size_t i = 0; i < 3; ++i) EXPECT_GE(lasted_s[i], 0.8 * 0.2 * (1 << i));
}

// A damaged frame is dropped and a keyframe requested; the stream continues.
TEST(SpoiledFrame, IsDroppedAndRequestsKeyframe) {
  ScriptedServer server;
  server.on_join = let_in;
  server.on_stream = [](int, ScriptedServer::ServerStream& stream) {
    DriverFrame frame = frame_of_a_lattice();
    frame.tick = 1;
    EncodedStreamFrame encoded = encode_stream_frame(frame, nullptr);
    send(stream, 1, encoded);
    frame.tick = 2;
    frame.objects[0].positions_m.assign(8, Eigen::Vector3f(0.5f, 0.1f, 0));
    encoded = encode_stream_frame(frame, encoded.next);
    send(stream, 2, encoded, true);
    v1::ClientMessage incoming;
    while (stream.Read(&incoming)) {
      if (!incoming.key_frame_wanted()) continue;
      frame.tick = 3;
      send(stream, 3, encode_stream_frame(frame, nullptr));
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

// The first frame and the requested keyframe are both damaged: the request is repeated while unreadable
// frames arrive.
TEST(SpoiledFrame, RequestIsRepeatedForSpoiledKeyframe) {
  ScriptedServer server;
  server.on_join = let_in;
  std::atomic<int> asked = 0;
  server.on_stream = [&](int, ScriptedServer::ServerStream& stream) {
    DriverFrame frame = frame_of_a_lattice();
    const auto send_key = [&](bool spoiled) {
      ++frame.tick;
      send(stream, frame.tick, encode_stream_frame(frame, nullptr), spoiled);
    };
    send_key(true);
    v1::ClientMessage incoming;
    while (stream.Read(&incoming)) {  // a keepalive at least every 50 ms
      if (incoming.key_frame_wanted()) ++asked;
      send_key(asked < 2);
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
  EXPECT_GE(asked, 2);
  EXPECT_LE(asked, 3);  // not for every unreadable frame
}

// A late or merged message loses no button press: each message holds the last three samples, oldest first,
// including acknowledgements and keepalives.
TEST(Inputs, MessagesContainLastThreeSamples) {
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<std::vector<uint64_t>> received;  // the sequences in each message
  ScriptedServer server;
  server.on_join = let_in;
  server.on_stream = [&](int, ScriptedServer::ServerStream& stream) {
    v1::ServerMessage message;
    DriverFrame frame;
    frame.tick = 7;
    message.set_tick(7);
    const auto encoded = encode_stream_frame(frame, nullptr);
    message.set_frame(encoded.bytes.data(), encoded.bytes.size());
    stream.Write(message);
    v1::ClientMessage incoming;
    while (stream.Read(&incoming)) {
      std::vector<uint64_t> sequences;
      for (const v1::Input& input : incoming.inputs()) sequences.push_back(input.sequence());
      std::lock_guard lock(mutex);
      received.push_back(std::move(sequences));
      changed.notify_all();
    }
    return grpc::Status::OK;
  };
  server.start();
  auto joined = SessionClient::join(server.address(), patient());
  ASSERT_TRUE(joined) << joined.error().message;
  SinkLog sink;
  (*joined)->start(sink);
  ASSERT_TRUE(sink.wait([](const SinkLog::State& state) { return !state.frames.empty(); }));
  const auto wait_for = [&](const std::function<bool()>& enough) {
    std::unique_lock lock(mutex);
    return changed.wait_for(lock, kPatience, enough);
  };
  for (uint64_t sequence = 1; sequence <= 6; ++sequence) {
    InputSample sample;
    sample.sequence = sequence;
    sample.hands[1].active = true;
    sample.hands[1].shoot = sequence == 4;  // one press in one sample
    (*joined)->send(sample);
    ASSERT_TRUE(wait_for([&] {
      return !received.empty() && !received.back().empty() && received.back().back() == sequence;
    })) << sequence;
  }
  const size_t before = [&] {
    std::lock_guard lock(mutex);
    return received.size();
  }();
  ASSERT_TRUE(wait_for([&] { return received.size() >= before + 3; }));  // keepalives
  EXPECT_TRUE((*joined)->stop());
  std::lock_guard lock(mutex);
  size_t with_the_press = 0;
  for (const std::vector<uint64_t>& sequences : received) {
    if (sequences.empty()) continue;  // before the first sample
    const uint64_t newest = sequences.back();
    std::vector<uint64_t> last_three;
    for (uint64_t one = newest > 3 ? newest - 2 : 1; one <= newest; ++one) last_three.push_back(one);
    EXPECT_EQ(sequences, last_three);
    with_the_press += std::count(sequences.begin(), sequences.end(), 4u) > 0 ? 1 : 0;
  }
  EXPECT_GE(with_the_press, 3u);
  EXPECT_EQ(received.back(), (std::vector<uint64_t>{4, 5, 6}));
}

// Two samples for each of ten presses, sent at once: none is left out.
TEST(Inputs, BurstOfSamplesIsSentWhole) {
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<uint64_t> received;  // sequences, each once
  int most_in_a_message = 0;
  ScriptedServer server;
  server.on_join = let_in;
  server.on_stream = [&](int, ScriptedServer::ServerStream& stream) {
    v1::ServerMessage message;
    DriverFrame frame;
    frame.tick = 7;
    message.set_tick(7);
    const auto encoded = encode_stream_frame(frame, nullptr);
    message.set_frame(encoded.bytes.data(), encoded.bytes.size());
    stream.Write(message);
    v1::ClientMessage incoming;
    while (stream.Read(&incoming)) {
      std::lock_guard lock(mutex);
      most_in_a_message = std::max(most_in_a_message, incoming.inputs_size());
      for (const v1::Input& input : incoming.inputs()) {
        if (received.empty() || input.sequence() > received.back()) received.push_back(input.sequence());
      }
      changed.notify_all();
    }
    return grpc::Status::OK;
  };
  server.start();
  auto joined = SessionClient::join(server.address(), patient());
  ASSERT_TRUE(joined) << joined.error().message;
  SinkLog sink;
  (*joined)->start(sink);
  ASSERT_TRUE(sink.wait([](const SinkLog::State& state) { return !state.frames.empty(); }));
  constexpr uint64_t kSamples = 20;
  for (uint64_t sequence = 1; sequence <= kSamples; ++sequence) {
    InputSample sample;
    sample.sequence = sequence;
    sample.hands[1].active = true;
    sample.hands[1].shoot = sequence % 2 == 1;
    (*joined)->send(sample);
  }
  {
    std::unique_lock lock(mutex);
    EXPECT_TRUE(
        changed.wait_for(lock, kPatience, [&] { return !received.empty() && received.back() == kSamples; }));
    EXPECT_EQ(received.size(), kSamples);
    EXPECT_LE(most_in_a_message, 8);  // the limit of the server
  }
  EXPECT_TRUE((*joined)->stop());
}

}  // namespace
}  // namespace livegs
