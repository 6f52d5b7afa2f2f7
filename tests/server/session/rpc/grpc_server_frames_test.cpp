// SPDX-License-Identifier: Apache-2.0
// Frames of a client by its options of Join, moved objects and window.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <set>

#include "server/session/rpc/grpc_server_fixture.h"
#include "wire/frame_stream.h"

namespace livegs {
namespace {

TEST_F(GrpcServerTest, RefusesInvalidRatesByField) {
  open();
  RawClient client(server_->port());
  for (const double mbit_s : {-1.0, 0.01, std::numeric_limits<double>::quiet_NaN()}) {
    grpc::ClientContext context;
    set_patience(context);
    v1::JoinRequest request;
    request.set_protocol_version(kProtocolVersion);
    request.set_max_mbit_s(mbit_s);
    const grpc::Status status = client.stub().Join(&context, request, &client.joined);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << mbit_s;
    EXPECT_EQ(status.error_message().rfind("max_mbit_s: ", 0), 0u) << status.error_message();
  }
}

TEST_F(GrpcServerTest, LowerRateSendsEveryNthTick) {
  open();
  RawClient client(server_->port());
  const auto join = [&](double rate_hz) {
    grpc::ClientContext context;
    set_patience(context);
    v1::JoinRequest request;
    request.set_protocol_version(kProtocolVersion);
    request.set_rate_hz(rate_hz);
    return client.stub().Join(&context, request, &client.joined);
  };
  for (const double rate_hz : {-30.0, 1.0, std::numeric_limits<double>::quiet_NaN()}) {
    const grpc::Status status = join(rate_hz);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << rate_hz;
    EXPECT_EQ(status.error_message().rfind("rate_hz: ", 0), 0u) << status.error_message();
  }
  for (const auto& [wish_hz, gets_hz] :
       {std::pair{0.0, 90.0}, {240.0, 90.0}, {72.0, 90.0}, {40.0, 45.0}, {30.0, 30.0}}) {
    ASSERT_TRUE(join(wish_hz).ok());
    EXPECT_DOUBLE_EQ(client.joined.stream_rate_hz(), gets_hz) << wish_hz;
    EXPECT_DOUBLE_EQ(client.joined.rate_hz(), 90.0);
  }
  // The last request was 30 Hz. The first frame is sent whatever its number. Tick 12 is missing, so 13 takes
  // its turn.
  client.open();
  StreamReader reader;
  const std::set<uint64_t> sent = {4, 6, 9, 13, 15};
  for (const uint64_t number : {4, 5, 6, 7, 8, 9, 10, 11, 13, 14, 15, 16}) {
    publish(number);
    if (!sent.contains(number)) continue;
    const v1::ServerMessage message = client.read();  // the next message: earlier ticks were not sent
    ASSERT_EQ(message.tick(), number);
    EXPECT_TRUE(reader.read(std::as_bytes(std::span(message.frame()))));
    ASSERT_TRUE(client.acknowledge(number));
  }
  EXPECT_TRUE(client.finish().ok());
}

// Fractures are announced at once, whatever the rate.
TEST_F(GrpcServerTest, EventsAreNotDelayedByTheRate) {
  open();
  RawClient client(server_->port());
  grpc::ClientContext context;
  set_patience(context);
  v1::JoinRequest request;
  request.set_protocol_version(kProtocolVersion);
  request.set_rate_hz(5);
  ASSERT_TRUE(client.stub().Join(&context, request, &client.joined).ok());
  client.open();
  publish(18);
  ASSERT_EQ(client.read().tick(), 18u);
  ASSERT_TRUE(client.acknowledge(18));
  TickResult stepped = tick(19);
  const SceneObject& ball = shoot();
  stepped.added.push_back(ball);
  server_->ticks().publish(std::move(stepped));
  const v1::ServerMessage message = client.read();
  ASSERT_EQ(message.events_size(), 1);
  EXPECT_EQ(message.events(0).object_added().object_id(), ball.id);
  EXPECT_TRUE(message.frame().empty());
  EXPECT_TRUE(client.finish().ok());
}

TEST_F(GrpcServerTest, RefusesInvalidPrecisionByField) {
  open();
  RawClient client(server_->port());
  for (const uint32_t bits : {1u, 15u, 17u, 21u, 4'000'000'000u}) {
    client.position_bits = bits;
    const grpc::Status status = client.join();
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << bits;
    EXPECT_EQ(status.error_message().rfind("position_bits: ", 0), 0u) << status.error_message();
  }
}

// Each of three clients has its own precision, while all are sent the same ticks.
TEST_F(GrpcServerTest, PositionsHaveTheRequestedPrecision) {
  open();
  const std::vector<uint32_t> bits = {0, 18, 20};
  std::vector<std::unique_ptr<RawClient>> clients;
  std::vector<StreamReader> readers(bits.size());
  for (const uint32_t wanted : bits) {
    clients.push_back(std::make_unique<RawClient>(server_->port()));
    clients.back()->position_bits = wanted;
    ASSERT_TRUE(clients.back()->join().ok());
    clients.back()->open();
  }
  std::vector<float> off_m(bits.size(), 0);
  for (uint64_t number = 1; number <= 5; ++number) {
    TickResult moved = tick(number);
    ObjectDrivers& body = moved.drivers.objects.emplace_back();
    body.object_id = 1000;
    body.kind = DriverKind::Lattice;
    for (int i = 0; i < 50; ++i)
      body.positions_m.emplace_back(0.0137f * static_cast<float>(i),
                                    0.1f * std::sin(static_cast<float>(number + i)), 0.3f);
    const std::vector<Eigen::Vector3f> sent = body.positions_m;
    server_->ticks().publish(std::move(moved));
    for (size_t c = 0; c < clients.size(); ++c) {
      const auto frame = readers[c].read(std::as_bytes(std::span(clients[c]->read().frame())));
      ASSERT_TRUE(frame) << frame.error().message;
      const auto read = std::find_if(frame->objects.begin(), frame->objects.end(),
                                     [](const auto& o) { return o.object_id == 1000; });
      ASSERT_NE(read, frame->objects.end());
      for (size_t i = 0; i < sent.size(); ++i)
        off_m[c] = std::max(off_m[c], (read->positions_m[i] - sent[i]).cwiseAbs().maxCoeff());
      ASSERT_TRUE(clients[c]->acknowledge(number));
    }
  }
  for (size_t c = 0; c < bits.size(); ++c) {
    const float half_step_m =
        0.9375f * std::exp2(-15.0f - static_cast<float>(bits[c] == 0 ? 0 : bits[c] - 16));
    EXPECT_LE(off_m[c], half_step_m + 1e-7f) << bits[c];
    EXPECT_GT(off_m[c], 0.5f * half_step_m) << bits[c];
  }
}

TEST_F(GrpcServerTest, FramesArriveAndDecodeToWhatWasPublished) {
  open();
  RawClient client(server_->port());
  ASSERT_TRUE(client.join().ok());
  client.open();
  StreamReader reader;
  for (uint64_t number = 1; number <= 10; ++number) {
    publish(number);
    const v1::ServerMessage message = client.read();
    ASSERT_EQ(message.tick(), number);
    EXPECT_DOUBLE_EQ(message.step_ms(), 1.5);
    const auto frame = reader.read(std::as_bytes(std::span(message.frame())));
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ(frame->tick, number);
    EXPECT_EQ(frame->objects.size(), 3u);
    ASSERT_TRUE(client.acknowledge(number));
  }
  EXPECT_TRUE(client.finish().ok());
  EXPECT_TRUE(inputs_.wait_forgotten(1));
}

// Objects that did not move since the last frame of this client are not sent again. A client that asks for a
// keyframe gets one.
TEST_F(GrpcServerTest, FramesContainMovedObjectsOrAKeyframe) {
  constexpr uint64_t kApart = 14;  // ticks, longer than kRestInterval_ns: a scene at rest has a frame in each
  open();
  RawClient client(server_->port());
  ASSERT_TRUE(client.join().ok());
  client.open();
  size_t first = 0;
  for (uint64_t number = 1; number <= 3; ++number) {
    server_->ticks().publish(tick(kApart * number));
    const v1::ServerMessage message = client.read();
    if (number == 1) {
      first = message.frame().size();
    } else {
      EXPECT_LE(message.frame().size(), 20u);  // nothing moves between these ticks
      EXPECT_LT(20u, first);
    }
    ASSERT_TRUE(client.acknowledge(kApart * number));
  }
  v1::ClientMessage wish;
  wish.set_acknowledged_tick(3 * kApart);
  wish.set_key_frame_wanted(true);
  ASSERT_TRUE(client.send(wish));
  // The request is concurrent with the ticks: it takes effect within a few.
  bool key = false;
  for (uint64_t number = 4; number <= 200 && !key; ++number) {
    server_->ticks().publish(tick(kApart * number));
    const v1::ServerMessage message = client.read();
    key = StreamReader().read(std::as_bytes(std::span(message.frame()))).has_value();
    ASSERT_TRUE(client.acknowledge(kApart * number));
  }
  EXPECT_TRUE(key);
  EXPECT_TRUE(client.finish().ok());
}

TEST_F(GrpcServerTest, ClientWithoutAcknowledgementsGetsTwoFrames) {
  open();
  RawClient silent(server_->port()), quick(server_->port());
  for (RawClient* client : {&silent, &quick}) {
    ASSERT_TRUE(client->join().ok());
    client->open();
  }
  for (uint64_t number = 1; number <= 10; ++number) {
    publish(number);
    if (number <= 2) {
      ASSERT_EQ(silent.read().tick(), number);
    }
    ASSERT_TRUE(silent.acknowledge(0));      // keepalive only
    ASSERT_EQ(quick.read().tick(), number);  // the other client is not delayed
    ASSERT_TRUE(quick.acknowledge(number));
  }
  ASSERT_TRUE(silent.acknowledge(2));
  // A third frame would arrive now. The tick is 9 if its 10 was still pending when the quick client had read.
  EXPECT_GE(silent.read().tick(), 9u);
  EXPECT_TRUE(silent.finish().ok());
  EXPECT_TRUE(quick.finish().ok());
}

}  // namespace
}  // namespace livegs
