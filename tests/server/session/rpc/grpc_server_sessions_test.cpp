// SPDX-License-Identifier: Apache-2.0
// Sessions whose streams are silent, break or are resumed.
#include <atomic>
#include <thread>

#include "server/session/rpc/grpc_server_fixture.h"

namespace livegs {
namespace {

TEST_F(GrpcServerTest, SessionHasOneStream) {
  open();
  RawClient first(server_->port()), second(server_->port()), stranger(server_->port());
  ASSERT_TRUE(first.join().ok());
  first.open();
  publish(1);
  ASSERT_EQ(first.read().tick(), 1u);
  second.joined.set_session_id(first.joined.session_id());
  second.open();
  EXPECT_EQ(second.finish().error_code(), grpc::StatusCode::ALREADY_EXISTS);
  stranger.joined.set_session_id("nobody");
  stranger.open();
  EXPECT_EQ(stranger.finish().error_code(), grpc::StatusCode::NOT_FOUND);
  ASSERT_TRUE(first.acknowledge(1));
  publish(2);
  EXPECT_EQ(first.read().tick(), 2u);
}

// A stream without messages ends after two seconds. Until then keepalives arrive even without ticks. Its
// session is kept.
TEST_F(GrpcServerTest, SilentStreamEnds) {
  open();
  RawClient client(server_->port());
  ASSERT_TRUE(client.join().ok());
  client.open();
  publish(1);
  ASSERT_EQ(client.read().tick(), 1u);
  v1::ServerMessage send_keepalive;
  int beats = 0;
  while (client.read_any(send_keepalive)) {
    EXPECT_TRUE(send_keepalive.frame().empty());
    ++beats;
  }
  EXPECT_GE(beats, 4);  // one per 200 to 300 ms
  EXPECT_EQ(client.finish().error_code(), grpc::StatusCode::CANCELLED);
  while (server_->streaming_count() > 0) std::this_thread::yield();
  EXPECT_EQ(server_->client_count(), 1u);
  EXPECT_EQ(inputs_.forgotten(), 0u);
}

// Silent streams hold no slots; a client with a session continues.
TEST_F(GrpcServerTest, StreamWithoutSessionEnds) {
  open();
  RawClient there(server_->port());
  ASSERT_TRUE(there.join().ok());
  there.open();
  std::vector<std::unique_ptr<RawClient>> silent;
  for (int i = 0; i < 20; ++i) {
    silent.push_back(std::make_unique<RawClient>(server_->port()));
    silent.back()->open_silently();
  }
  std::atomic<bool> done{false};
  std::thread signs_of_life([&] {
    for (; !done; std::this_thread::sleep_for(std::chrono::milliseconds(100)))
      EXPECT_TRUE(there.acknowledge(0));
  });
  for (const auto& client : silent) {
    const grpc::Status status = client->finish_reading();
    EXPECT_EQ(status.error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
    EXPECT_EQ(status.error_message(),
              "stream: no message within 2 s; send the session_id first");  // not a timeout of the test
  }
  done = true;
  signs_of_life.join();
  publish(1);
  EXPECT_EQ(there.read().tick(), 1u);
  EXPECT_TRUE(there.finish().ok());
}

// The client resumes the same session and receives all objects; changes in between are not sent as events.
TEST_F(GrpcServerTest, SessionOutlivesACancelledStream) {
  open();
  RawClient client(server_->port());
  ASSERT_TRUE(client.join().ok());
  const v1::JoinReply first = client.joined;
  client.open();
  publish(1);
  ASSERT_EQ(client.read().tick(), 1u);
  client.cancel();
  EXPECT_FALSE(client.finish().ok());
  TickResult stepped = tick(2);
  const SceneObject& ball = shoot();
  stepped.added.push_back(ball);
  server_->ticks().publish(std::move(stepped));
  // The publisher thread handles the tick of the ball; clients that join later receive the ball.
  RawClient other(server_->port());
  while (other.joined.objects_size() < 4) ASSERT_TRUE(other.join().ok());
  ASSERT_TRUE(client.join(kProtocolVersion, first.session_id()).ok());
  EXPECT_EQ(client.joined.session_id(), first.session_id());
  EXPECT_EQ(client.joined.server_instance(), first.server_instance());
  ASSERT_EQ(client.joined.objects_size(), 4);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(client.joined.objects(i).SerializeAsString(), first.objects(i).SerializeAsString());
  }
  EXPECT_EQ(client.joined.objects(3).object_id(), ball.id);
  client.open();
  publish(3);
  const v1::ServerMessage message = client.read();
  EXPECT_EQ(message.tick(), 3u);
  EXPECT_EQ(message.events_size(), 0);
  EXPECT_TRUE(StreamReader().read(std::as_bytes(std::span(message.frame()))));  // a keyframe
  EXPECT_EQ(inputs_.forgotten(), 0u);
}

// The server has not noticed that the client's network failed: the old stream does not block the new one.
TEST_F(GrpcServerTest, RejoinReplacesTheOldStream) {
  open();
  RawClient old(server_->port()), again(server_->port());
  ASSERT_TRUE(old.join().ok());
  old.open();
  publish(1);
  ASSERT_EQ(old.read().tick(), 1u);
  ASSERT_TRUE(again.join(kProtocolVersion, old.joined.session_id()).ok());
  EXPECT_EQ(again.joined.session_id(), old.joined.session_id());
  again.open();
  EXPECT_FALSE(old.finish().ok());
  publish(2);
  EXPECT_EQ(again.read().tick(), 2u);
  EXPECT_TRUE(again.finish().ok());
  EXPECT_TRUE(inputs_.wait_forgotten(1));  // after it has ended in order
}

TEST_F(GrpcServerTest, EndedSessionIsReplacedByANewOne) {
  open();
  RawClient client(server_->port());
  ASSERT_TRUE(client.join(kProtocolVersion, std::string(32, 'a')).ok());
  EXPECT_NE(client.joined.session_id(), std::string(32, 'a'));
}

}  // namespace
}  // namespace livegs
