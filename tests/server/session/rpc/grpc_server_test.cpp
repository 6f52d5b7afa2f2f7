// SPDX-License-Identifier: Apache-2.0
// The gRPC server alone: the test supplies ticks one at a time, so that a client's view is known.
#include <grpcpp/generic/generic_stub.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <thread>

#include "common/gaussian/synthetic_asset.h"
#include "core/content_hash.h"
#include "gaussian/asset_file.h"
#include "gaussian/progressive_asset.h"
#include "server/session/rpc/grpc_server_fixture.h"
#include "session/frames/send_budget.h"
#include "wire/call_metadata.h"
#include "wire/rest_body_codec.h"

namespace livegs {
namespace {

TEST_F(GrpcServerTest, JoinListsObjectsWithTheEnvironmentFirst) {
  open();
  RawClient client(server_->port());
  ASSERT_TRUE(client.join().ok());
  ASSERT_EQ(client.joined.objects_size(), 3);  // the rendered floor, box and cube
  EXPECT_TRUE(client.joined.objects(0).environment());
  EXPECT_EQ(client.joined.objects(1).name(), "box");
  EXPECT_DOUBLE_EQ(client.joined.rate_hz(), 90.0);
  const auto rest = decode_rest_body(std::as_bytes(std::span(client.joined.objects(2).rest_body())));
  ASSERT_TRUE(rest) << rest.error().message;
  EXPECT_EQ(rest->kind, DriverKind::Lattice);
  EXPECT_EQ(rest->node_coordinates.size(), client.joined.objects(2).driver_count());
}

// A client knows the accuracy of the cube's stiffness before the first tick; a rigid box has none.
TEST_F(GrpcServerTest, ObjectsIncludeTheirAccuracy) {
  open();
  RawClient client(server_->port());
  ASSERT_TRUE(client.join().ok());
  EXPECT_FALSE(client.joined.objects(1).has_elastic());
  const ElasticAccuracy accuracy = scene_.world().elastic_body(scene_.find("cube")->id)->accuracy();
  v1::AnalyzeObjectRequest request;
  request.set_object("cube");
  v1::AnalyzeObjectReply reply;
  grpc::ClientContext context;
  set_patience(context);
  ASSERT_TRUE(client.stub().AnalyzeObject(&context, request, &reply).ok());
  for (const v1::ElasticAccuracy& reported : {client.joined.objects(2).elastic(), reply.elastic()}) {
    EXPECT_EQ(reported.cell_width_m(), accuracy.cell_width_m);
    EXPECT_EQ(reported.substeps(), static_cast<uint32_t>(accuracy.substeps));
    EXPECT_EQ(reported.courant(), accuracy.courant);
    EXPECT_EQ(reported.youngs_modulus_pa(), 2e4);  // as in the scene
    EXPECT_EQ(reported.reached_youngs_modulus_pa(), accuracy.reached_youngs_modulus_pa);
    EXPECT_EQ(reported.nodes(), client.joined.objects(2).driver_count());
    EXPECT_GT(reported.nodes(), 0u);
  }
}

TEST_F(GrpcServerTest, JoinWaitsForTheScene) {
  RawClient client(server_->port());
  EXPECT_EQ(client.join().error_code(), grpc::StatusCode::UNAVAILABLE);
  open();
  EXPECT_TRUE(client.join().ok());
}

TEST_F(GrpcServerTest, RefusesOtherProtocolVersions) {
  open();
  RawClient client(server_->port());
  const grpc::Status status = client.join(kProtocolVersion + 1);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_NE(status.error_message().find("update the older one"), std::string::npos) << status.error_message();
}

TEST_F(GrpcServerTest, LimitsTheNumberOfSessions) {
  open();
  RawClient client(server_->port());
  for (size_t i = 0; i < kDefaultSessions; ++i) ASSERT_TRUE(client.join().ok());
  EXPECT_EQ(client.join().error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
}

TEST_F(GrpcServerTest, LimitOfSessionsIsConfigurable) {
  server_->admit(66);
  open();
  RawClient client(server_->port());
  for (size_t i = 0; i < 66; ++i) ASSERT_TRUE(client.join().ok());
  const grpc::Status refused = client.join();
  EXPECT_EQ(refused.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(refused.error_message().rfind("clients: 66 are", 0), 0u) << refused.error_message();
}

TEST_F(GrpcServerTest, EventsArriveCompleteAndInOrder) {
  open();
  RawClient client(server_->port());
  ASSERT_TRUE(client.join().ok());
  client.open();
  publish(1);
  ASSERT_EQ(client.read().tick(), 1u);
  publish(2);
  ASSERT_EQ(client.read().tick(), 2u);
  // The window is full. Twenty balls are added, all but four are removed; ids are never reused.
  std::vector<uint32_t> shot;
  for (uint64_t number = 3; number <= 22; ++number) {
    shoot();
    const Scene::Changes changes = scene_.take_changes();
    TickResult stepped = tick(number);
    for (uint32_t id : changes.added) {
      stepped.added.push_back(*scene_.find(id));
      shot.push_back(id);
    }
    stepped.removed = changes.removed;
    server_->ticks().publish(std::move(stepped));
    ASSERT_TRUE(client.acknowledge(0));  // keepalive only
  }
  std::vector<uint32_t> added, removed;
  const size_t expected_removed = shot.size() - Scene::kMaxBalls;
  while (added.size() < shot.size() || removed.size() < expected_removed) {
    const v1::ServerMessage message = client.read();
    ASSERT_GT(message.events_size(), 0);
    EXPECT_TRUE(message.frame().empty());
    for (const v1::SessionEvent& event : message.events()) {
      if (event.has_object_added()) added.push_back(event.object_added().object_id());
      if (event.has_object_removed()) {
        removed.push_back(event.object_removed().object_id());
        EXPECT_NE(std::find(added.begin(), added.end(), removed.back()), added.end());
      }
    }
  }
  EXPECT_EQ(added, shot);
  EXPECT_EQ(removed, std::vector<uint32_t>(shot.begin(), shot.begin() + static_cast<long>(expected_removed)));
  ASSERT_TRUE(client.acknowledge(2));
  EXPECT_EQ(client.read().tick(), 22u);

  // A client that joins now receives the remaining balls.
  RawClient late(server_->port());
  ASSERT_TRUE(late.join().ok());
  EXPECT_EQ(late.joined.objects_size(), 3 + static_cast<int>(Scene::kMaxBalls));
}

TEST_F(GrpcServerTest, EventsBetweenJoinAndStreamAreKept) {
  open();
  RawClient client(server_->port());
  ASSERT_TRUE(client.join().ok());
  const SceneObject& ball = shoot();
  TickResult stepped = tick(1);
  stepped.added.push_back(ball);
  server_->ticks().publish(std::move(stepped));
  client.open();
  uint32_t added = 0;
  for (;;) {
    const v1::ServerMessage message = client.read();
    for (const v1::SessionEvent& event : message.events()) added = event.object_added().object_id();
    if (message.tick() == 1) break;
    ASSERT_GT(message.events_size(), 0);
  }
  EXPECT_EQ(added, ball.id);
}

TEST_F(GrpcServerTest, InputsReachTheSimulation) {
  open();
  RawClient client(server_->port());
  ASSERT_TRUE(client.join().ok());
  client.open();
  v1::ClientMessage message;
  message.set_sent_ns(12345);
  for (uint64_t sequence : {4u, 5u, 6u}) message.add_inputs()->set_sequence(sequence);
  ASSERT_TRUE(client.send(message));
  EXPECT_TRUE(inputs_.wait_heard(3));
  publish(1);
  EXPECT_EQ(client.read().echoed_ns(), 12345);
}

TEST_F(GrpcServerTest, NonFiniteNumberEndsOnlyItsStream) {
  open();
  RawClient bad(server_->port()), good(server_->port());
  for (RawClient* client : {&bad, &good}) {
    ASSERT_TRUE(client->join().ok());
    client->open();
  }
  v1::ClientMessage message;
  v1::Input& input = *message.add_inputs();
  input.set_sequence(1);
  for (int i = 0; i < 3; ++i) {
    input.mutable_left()->add_aim_position_m(std::nanf(""));
    input.mutable_left()->add_grip_position_m(0);
  }
  for (float value : {1.0f, 0.0f, 0.0f, 0.0f}) {
    input.mutable_left()->add_aim_orientation(value);
    input.mutable_left()->add_grip_orientation(value);
  }
  bad.send(message);
  const grpc::Status status = bad.finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_NE(status.error_message().find("left.aim_position_m"), std::string::npos) << status.error_message();
  publish(1);
  EXPECT_EQ(good.read().tick(), 1u);
}

// Random bytes, sent as messages of Stream.
TEST_F(GrpcServerTest, SurvivesRandomBytes) {
  open();
  std::mt19937_64 random(7);
  const auto channel = channel_to(server_->port());
  grpc::GenericStub stub(channel);
  for (int round = 0; round < 30; ++round) {
    std::string bytes(random() % 4096, '\0');
    for (char& byte : bytes) byte = static_cast<char>(random());
    grpc::ClientContext context;
    set_patience(context);
    grpc::CompletionQueue queue;
    const auto call = stub.PrepareCall(&context, "/livegs.v1.LiveGs/Stream", &queue);
    const auto next = [&] {
      void* tag = nullptr;
      bool ok = false;
      EXPECT_TRUE(queue.Next(&tag, &ok));
      return ok;
    };
    call->StartCall(nullptr);
    ASSERT_TRUE(next());
    const grpc::Slice slice(bytes);
    call->Write(grpc::ByteBuffer(&slice, 1), nullptr);
    next();
    grpc::Status status;
    call->Finish(&status, nullptr);
    next();
    EXPECT_TRUE(status.error_code() == grpc::StatusCode::INVALID_ARGUMENT ||
                status.error_code() == grpc::StatusCode::NOT_FOUND)
        << status.error_code() << " " << status.error_message();
    queue.Shutdown();
  }
  RawClient client(server_->port());
  ASSERT_TRUE(client.join().ok());
  client.open();
  publish(1);
  EXPECT_EQ(client.read().tick(), 1u);
}

TEST_F(GrpcServerTest, RefusesOversizedMessages) {
  open();
  RawClient client(server_->port());
  ASSERT_TRUE(client.join().ok());
  client.open();
  v1::ClientMessage message;
  message.set_session_id(std::string(1 << 20, 'x'));
  client.send(message);
  EXPECT_EQ(client.finish().error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
}

TEST_F(GrpcServerTest, AssetsAreFetchedFromAnyOffset) {
  open();
  RawClient client(server_->port());
  ASSERT_TRUE(client.join().ok());
  const v1::ObjectDescription& box = client.joined.objects(1);
  const auto fetch = [&](const std::string& hash, uint64_t offset, std::string& bytes) {
    grpc::ClientContext context;
    set_patience(context);
    v1::FetchAssetRequest request;
    request.set_asset_hash(hash);
    request.set_offset(offset);
    const auto reader = client.stub().FetchAsset(&context, request);
    v1::AssetChunk chunk;
    while (reader->Read(&chunk)) {
      EXPECT_EQ(chunk.offset(), offset + bytes.size());
      EXPECT_EQ(chunk.total_bytes(), box.asset_bytes());
      EXPECT_LE(chunk.data().size(), size_t{1} << 20);
      bytes += chunk.data();
    }
    return reader->Finish();
  };
  std::string whole, rest, none, error;
  ASSERT_TRUE(fetch(box.asset_hash(), 0, whole).ok());
  EXPECT_EQ(whole.size(), box.asset_bytes());
  const auto asset = decode_progressive(std::as_bytes(std::span(whole)));
  ASSERT_TRUE(asset) << asset.error().message;
  EXPECT_EQ(asset->size(), box.kernel_count());
  EXPECT_EQ(content_hash(encode_ply(*asset)), box.asset_hash());
  ASSERT_TRUE(fetch(box.asset_hash(), 1000, rest).ok());
  EXPECT_EQ(rest, whole.substr(1000));
  EXPECT_TRUE(fetch(box.asset_hash(), whole.size(), none).ok());
  EXPECT_TRUE(none.empty());
  EXPECT_EQ(fetch(box.asset_hash(), whole.size() + 1, error).error_code(), grpc::StatusCode::OUT_OF_RANGE);
  EXPECT_EQ(fetch("../../etc/passwd", 0, error).error_code(), grpc::StatusCode::NOT_FOUND);
}

// Bytes that arrived since its construction, compared with a cap. A delay on the way only makes them fewer.
class CapMeter {
 public:
  explicit CapMeter(double mbit_s) : cap_bytes_s_(mbit_s * 1e6 / 8) {}
  void add(size_t bytes) {
    std::lock_guard lock(mutex_);
    bytes_ += static_cast<double>(bytes);
    const double allowed = cap_bytes_s_ * (seconds_from_ns(now_ns() - begun_ns_) + SendBudget::kBurst_s);
    excess_bytes_ = std::max(excess_bytes_, bytes_ - allowed);
  }
  double excess_bytes() const {
    std::lock_guard lock(mutex_);
    return excess_bytes_;
  }

 private:
  const double cap_bytes_s_;
  const int64_t begun_ns_ = now_ns();
  mutable std::mutex mutex_;
  double bytes_ = 0, excess_bytes_ = 0;
};

TEST_F(GrpcServerTest, AssetsAndFramesShareTheCap) {
  constexpr double kMbit_s = 2;
  SceneObject big = *scene_.find("box");
  big.asset = std::make_shared<const GaussianAsset>(synthetic_asset(50'000, 0, 1));
  const SceneObject* const objects[] = {&big};
  server_->cap_clients(kMbit_s);
  server_->open("big", 90, objects, inputs_);
  RawClient client(server_->port());
  ASSERT_TRUE(client.join().ok());
  const v1::ObjectDescription& box = client.joined.objects(0);
  ASSERT_GT(box.asset_bytes(), 1'000'000u);
  // Fetches until `enough` bytes arrived.
  const auto fetch = [&](const std::string& session_id, CapMeter& meter, size_t enough) {
    grpc::ClientContext context;
    set_patience(context);
    if (!session_id.empty()) context.AddMetadata(kSessionMetadata, session_id);
    v1::FetchAssetRequest request;
    request.set_asset_hash(box.asset_hash());
    const auto reader = client.stub().FetchAsset(&context, request);
    v1::AssetChunk chunk;
    size_t bytes = 0;
    while (bytes < enough && reader->Read(&chunk)) {
      bytes += chunk.data().size();
      meter.add(chunk.data().size());
    }
    context.TryCancel();
    reader->Finish();
    return bytes;
  };
  {
    CapMeter meter(kMbit_s);
    size_t fetched = 0;
    std::thread fetches([&] { fetched = fetch(client.joined.session_id(), meter, 150'000); });
    client.open();
    for (uint64_t number = 1; number <= 50; ++number) {
      publish(number);
      const v1::ServerMessage message = client.read();
      meter.add(message.ByteSizeLong());
      EXPECT_EQ(message.tick(), number);  // a fetch holds back no frame
      ASSERT_TRUE(client.acknowledge(message.tick()));
    }
    fetches.join();
    EXPECT_GE(fetched, 150'000u);
    EXPECT_LE(meter.excess_bytes(), 0);
  }
  for (const char* no_session : {"", "0123456789abcdef"}) {
    CapMeter meter(kMbit_s);
    std::thread other([&] { fetch(no_session, meter, 40'000); });  // they share the cap of the machine
    EXPECT_GE(fetch(no_session, meter, 40'000), 40'000u);
    other.join();
    EXPECT_LE(meter.excess_bytes(), 0);
  }
}

TEST_F(GrpcServerTest, AnalyzeReturnsRangesAndListsObjects) {
  open();
  RawClient client(server_->port());
  const auto analyze = [&](const std::string& name, v1::AnalyzeObjectReply& reply) {
    grpc::ClientContext context;
    set_patience(context);
    v1::AnalyzeObjectRequest request;
    request.set_object(name);
    return client.stub().AnalyzeObject(&context, request, &reply);
  };
  v1::AnalyzeObjectReply reply;
  ASSERT_TRUE(analyze("box", reply).ok());
  const v1::EstimatedValue& mass = reply.parameters().mass_kg();
  EXPECT_DOUBLE_EQ(mass.best(), 1.0);  // as in the scene
  EXPECT_LE(mass.low(), mass.best());
  EXPECT_GE(mass.high(), mass.best());
  EXPECT_EQ(mass.source(), v1::EstimatedValue::SCENE);
  EXPECT_FALSE(reply.parameters().youngs_modulus_pa().reason().empty());
  const grpc::Status status = analyze("hat", reply);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_NE(status.error_message().find("box, cube"), std::string::npos) << status.error_message();
}

TEST_F(GrpcServerTest, InfoCountsClients) {
  open();
  RawClient client(server_->port());
  ASSERT_TRUE(client.join().ok());
  grpc::ClientContext context;
  set_patience(context);
  v1::ServerInfo info;
  ASSERT_TRUE(client.stub().GetServerInfo(&context, {}, &info).ok());
  EXPECT_EQ(info.scene(), "boxes");
  EXPECT_EQ(info.protocol_version(), kProtocolVersion);
  EXPECT_EQ(info.client_count(), 1u);
  EXPECT_EQ(info.object_count(), 3u);
}

TEST_F(GrpcServerTest, ReportsAPortInUse) {
  const auto second = GrpcServer::listen("127.0.0.1:" + std::to_string(server_->port()));
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::Unavailable);
  EXPECT_NE(second.error().message.find("in use"), std::string::npos);
}

TEST(ListenAddress, MustBeLocalWithoutTls) {
  for (const char* address : {"127.0.0.1:0", "127.1.2.3:9780", "localhost:9780", "[::1]:65535"}) {
    EXPECT_TRUE(check_listen_address(address, false)) << address;
    EXPECT_TRUE(check_listen_address(address, true)) << address;
  }
  for (const char* address : {"0.0.0.0:9780", "192.168.1.2:9780", "[::]:9780", "example.org:9780"}) {
    EXPECT_TRUE(check_listen_address(address, true)) << address;
  }
  for (const char* address :
       {"0.0.0.0:9780", "192.168.1.2:9780", "[::]:9780", "example.org:9780", ":9780", "127.0.0.1",
        "127.0.0.1:", "127.0.0.1:65536", "127.0.0.1:-1", "127.0.0.1:12x", "127.0.0.1.example.org:80", ""}) {
    const auto checked = check_listen_address(address, false);
    ASSERT_FALSE(checked) << address;
    EXPECT_EQ(checked.error().code, ErrorCode::InvalidArgument);
  }
}

TEST_F(GrpcServerTest, ShutdownNotifiesEveryClient) {
  open();
  RawClient streaming(server_->port()), joined(server_->port()), frozen(server_->port());
  for (RawClient* client : {&streaming, &joined, &frozen}) ASSERT_TRUE(client->join().ok());
  streaming.open();
  frozen.open();
  publish(1);
  ASSERT_EQ(streaming.read().tick(), 1u);
  ASSERT_EQ(frozen.read().tick(), 1u);
  std::thread shutdown([&] { server_->shut_down("maintenance"); });
  std::string draining;
  for (;;) {
    const v1::ServerMessage message = streaming.read();
    for (const v1::SessionEvent& event : message.events()) draining = event.draining();
    if (!draining.empty() || message.ByteSizeLong() == 0) break;
  }
  EXPECT_EQ(draining, "maintenance");
  const grpc::Status status = streaming.finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(status.error_message(), "maintenance");
  shutdown.join();  // with a client that does not read and one that never streamed
}

// The standard health service, called with raw bytes: field 1 of the reply is the status, 1 for SERVING.
std::string health_reply(int port) {
  grpc::GenericStub stub(channel_to(port));
  grpc::ClientContext context;
  set_patience(context);
  grpc::CompletionQueue queue;
  const grpc::Slice empty;
  const auto call =
      stub.PrepareUnaryCall(&context, "/grpc.health.v1.Health/Check", grpc::ByteBuffer(&empty, 1), &queue);
  call->StartCall();
  grpc::ByteBuffer reply;
  grpc::Status status;
  call->Finish(&reply, &status, nullptr);
  void* tag = nullptr;
  bool ok = false;
  queue.Next(&tag, &ok);
  queue.Shutdown();
  EXPECT_TRUE(status.ok()) << status.error_message();
  grpc::Slice slice;
  EXPECT_TRUE(reply.DumpToSingleSlice(&slice).ok());
  return std::string(reinterpret_cast<const char*>(slice.begin()), slice.size());
}

TEST_F(GrpcServerTest, HealthFollowsTheScene) {
  EXPECT_EQ(health_reply(server_->port()), "\x08\x02");  // NOT_SERVING
  open();
  EXPECT_EQ(health_reply(server_->port()), "\x08\x01");
}

TEST_F(GrpcServerTest, ReflectionListsTheService) {
  open();
  grpc::GenericStub stub(channel_to(server_->port()));
  grpc::ClientContext context;
  set_patience(context);
  grpc::CompletionQueue queue;
  const auto next = [&] {
    void* tag = nullptr;
    bool ok = false;
    EXPECT_TRUE(queue.Next(&tag, &ok));
    return ok;
  };
  const auto call =
      stub.PrepareCall(&context, "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo", &queue);
  call->StartCall(nullptr);
  ASSERT_TRUE(next());
  const grpc::Slice list_services(std::string("\x3a\x01*"));  // field 7, list_services, "*"
  call->Write(grpc::ByteBuffer(&list_services, 1), nullptr);
  ASSERT_TRUE(next());
  grpc::ByteBuffer reply;
  call->Read(&reply, nullptr);
  ASSERT_TRUE(next());
  grpc::Slice slice;
  ASSERT_TRUE(reply.DumpToSingleSlice(&slice).ok());
  const std::string text(reinterpret_cast<const char*>(slice.begin()), slice.size());
  EXPECT_NE(text.find("livegs.v1.LiveGs"), std::string::npos);
  call->WritesDone(nullptr);
  next();
  grpc::Status status;
  call->Finish(&status, nullptr);
  next();
  queue.Shutdown();
}

}  // namespace
}  // namespace livegs
