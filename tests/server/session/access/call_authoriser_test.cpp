// SPDX-License-Identifier: Apache-2.0
// An in-process server with TLS and tokens, called with arbitrary credentials.
#include "session/access/call_authoriser.h"

#include <google/protobuf/descriptor.h>
#include <grpcpp/generic/generic_stub.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "livegs/v1/admin.grpc.pb.h"
#include "livegs/v1/spectate.grpc.pb.h"
#include "scratch_folder.h"
#include "server/session/rpc/grpc_server_fixture.h"
#include "session/access/server_security.h"
#include "trust/server_access.h"

namespace livegs {
namespace {

class Gate : public ::testing::Test {
 protected:
  Gate() : scene_(box_scene()) {
    auto security = ServerSecurity::open(folder_ / "state", [this] { return now_s_.load(); });
    EXPECT_TRUE(security) << security.error().message;
    security_ = std::move(*security);
    auto server = GrpcServer::listen("127.0.0.1:0", security_.get());
    EXPECT_TRUE(server) << server.error().message;
    server_ = std::move(*server);
    server_->open(scene_, inputs_);
  }
  std::string token(v1::Scope scope, double days = 1) {
    auto made = security_->tokens().add("a test's", scope, days);
    EXPECT_TRUE(made) << made.error().message;
    last_id_ = made->token.id();
    return made->secret;
  }
  std::shared_ptr<grpc::Channel> channel(const std::string& token, const std::string& fingerprint = "") {
    const std::string address = "127.0.0.1:" + std::to_string(server_->port());
    access_ = std::make_unique<ServerAccess>(
        address, ServerAccess::Keys{fingerprint.empty() ? security_->fingerprint() : fingerprint, "", token});
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
    return grpc::CreateCustomChannel(address, access_->credentials(), arguments);
  }
  // The status of an empty request.
  static grpc::Status call(const std::shared_ptr<grpc::Channel>& channel, const std::string& path) {
    grpc::GenericStub stub(channel);
    grpc::ClientContext context;
    set_patience(context);
    grpc::CompletionQueue queue;
    const auto started = stub.PrepareUnaryCall(&context, path, grpc::ByteBuffer(nullptr, 0), &queue);
    started->StartCall();
    grpc::ByteBuffer reply;
    grpc::Status status;
    started->Finish(&reply, &status, &reply);
    void* tag = nullptr;
    bool ok = false;
    queue.Next(&tag, &ok);
    return status;
  }
  void publish(uint64_t number) {
    TickResult tick;
    tick.drivers = scene_.world().drivers();
    tick.drivers.tick = number;
    tick.stepped_ns = now_ns();
    server_->ticks().publish(std::move(tick));
  }

  ScratchFolder folder_;
  std::atomic<int64_t> now_s_{1'700'000'000};
  Scene scene_;
  InputLog inputs_;
  std::unique_ptr<ServerSecurity> security_;
  std::unique_ptr<GrpcServer> server_;
  std::unique_ptr<ServerAccess> access_;
  std::string last_id_;
};

std::vector<std::string> all_paths() {
  std::vector<std::string> paths;
  for (const char* name : {"livegs.v1.LiveGs", "livegs.v1.Spectators", "livegs.v1.Admin"}) {
    const auto* service = google::protobuf::DescriptorPool::generated_pool()->FindServiceByName(name);
    EXPECT_NE(service, nullptr) << name;
    for (int i = 0; service != nullptr && i < service->method_count(); ++i)
      paths.push_back("/" + service->full_name() + "/" + service->method(i)->name());
  }
  paths.push_back("/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo");
  paths.push_back("/grpc.health.v1.Health/Watch");
  paths.push_back("/nobody.Serves/This");
  return paths;
}

// The expected scopes, independent of call_authoriser.cpp.
v1::Scope expected_scope(const std::string& path) {
  if (path == "/livegs.v1.Spectators/DescribeScene") return v1::VIEW;
  if (!path.starts_with("/livegs.v1.LiveGs/")) return v1::ADMIN;
  const std::string method = path.substr(path.rfind('/') + 1);
  if (method == "SetPhysics" || method == "UndoPhysics" || method == "AcceptProposal" ||
      method == "AnalyzeScene" || method == "ControlRun" || method == "EditScene" || method == "UndoEdit" ||
      method == "CarryObject" || method == "GetScene" || method == "SaveScene" || method == "ListAssets" ||
      method == "UploadAsset" || method == "GetRoomParts" || method == "TakePart" || method == "PutBack")
    return v1::AUTHOR;
  return method == "ApplyForce" ? v1::INTERACT : v1::VIEW;
}

TEST_F(Gate, ChecksTheScopeOfEveryCall) {
  for (const v1::Scope scope : {v1::VIEW, v1::INTERACT, v1::AUTHOR, v1::ADMIN}) {
    const auto open = channel(token(scope));
    for (const std::string& path : all_paths()) {
      if (path.ends_with("/Drain") || path.ends_with("/Stream") || path.ends_with("/AnalyzeScene") ||
          path.ends_with("ReflectionInfo") || path.ends_with("/Watch")) {
        if (scope >= expected_scope(path))
          continue;  // these stay open, or report that the scene is not ready
      }
      const grpc::Status status = call(open, path);
      EXPECT_NE(status.error_code(), grpc::StatusCode::UNAUTHENTICATED) << path;
      EXPECT_EQ(status.error_code() == grpc::StatusCode::PERMISSION_DENIED, scope < expected_scope(path))
          << path << " with " << scope_name(scope) << ": " << status.error_message();
    }
  }
}

TEST_F(Gate, NamesTheProblemOfEveryBadToken) {
  const std::string revoked = token(v1::ADMIN);
  ASSERT_TRUE(security_->tokens().revoke(last_id_));
  const std::string expired = token(v1::ADMIN, 1);
  now_s_ += 86400;
  const std::pair<std::string, std::string> cases[] = {{"", "token: is required"},
                                                       {"livegs_wrong", "not known to this server"},
                                                       {revoked, "was revoked"},
                                                       {expired, "has expired"}};
  for (const auto& [secret, answer] : cases) {
    const auto open = channel(secret);
    for (const std::string& path : all_paths()) {
      const grpc::Status status = call(open, path);
      EXPECT_EQ(status.error_code(), grpc::StatusCode::UNAUTHENTICATED) << path;
      EXPECT_NE(status.error_message().find(answer), std::string::npos)
          << path << ": " << status.error_message();
      if (!secret.empty()) {
        EXPECT_EQ(status.error_message().find(secret), std::string::npos);
      }
    }
    EXPECT_TRUE(call(open, "/grpc.health.v1.Health/Check").ok());  // reveals no more than an open port
  }
}

TEST_F(Gate, RefusesPlainTextAndUnknownCertificates) {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::milliseconds(500));
  v1::ServerInfo info;
  RawClient clear(server_->port());
  EXPECT_EQ(clear.stub().GetServerInfo(&context, {}, &info).error_code() == grpc::StatusCode::OK, false);

  std::string other = security_->fingerprint();
  other.back() = other.back() == '0' ? '1' : '0';
  const auto open = channel(token(v1::VIEW), other);
  EXPECT_EQ(call(open, "/livegs.v1.LiveGs/GetServerInfo").error_code(), grpc::StatusCode::UNAVAILABLE);
  const auto refused = access_->refused();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::PermissionDenied);
  EXPECT_NE(refused.error().message.find("differs from the paired one"), std::string::npos)
      << refused.error().message;
}

TEST_F(Gate, RevokedTokenEndsOnlyItsSessions) {
  const std::string kept = token(v1::INTERACT), lost = token(v1::INTERACT);
  const std::string lost_id = last_id_;
  RawClient stays(channel(kept)), goes(channel(lost));
  for (RawClient* client : {&stays, &goes}) {
    ASSERT_TRUE(client->join().ok());
    client->open();
  }
  publish(1);
  ASSERT_EQ(stays.read().tick(), 1u);
  ASSERT_EQ(goes.read().tick(), 1u);

  const auto admin = v1::Admin::NewStub(channel(token(v1::ADMIN)));
  grpc::ClientContext context;
  set_patience(context);
  v1::RevokeTokenRequest request;
  request.set_id(lost_id);
  v1::Token revoked;
  ASSERT_TRUE(admin->RevokeToken(&context, request, &revoked).ok());
  const grpc::Status status = goes.finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::PERMISSION_DENIED);
  EXPECT_NE(status.error_message().find("revoked"), std::string::npos) << status.error_message();
  EXPECT_TRUE(inputs_.wait_forgotten(1));
  EXPECT_EQ(goes.join().error_code(), grpc::StatusCode::UNAUTHENTICATED);
  EXPECT_EQ(server_->client_count(), 1u);
  ASSERT_TRUE(stays.acknowledge(1));
  publish(2);
  EXPECT_EQ(stays.read().tick(), 2u);
}

TEST_F(Gate, ExpiredTokenEndsItsSessions) {
  RawClient client(channel(token(v1::VIEW, 1)));
  ASSERT_TRUE(client.join().ok());
  client.open();
  publish(1);
  ASSERT_EQ(client.read().tick(), 1u);
  now_s_ += 86400;
  // Tokens are checked once a second; frames continue until then.
  const grpc::Status status = client.finish_reading();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::PERMISSION_DENIED);
  EXPECT_NE(status.error_message().find("has expired"), std::string::npos) << status.error_message();
}

v1::ClientMessage squeezing(uint64_t sequence) {
  v1::ClientMessage message;
  v1::Input& input = *message.add_inputs();
  input.set_sequence(sequence);
  v1::HandInput& hand = *input.mutable_right();
  for (int i = 0; i < 3; ++i) {
    hand.add_aim_position_m(0);
    hand.add_grip_position_m(0);
  }
  for (const float w : {1.0f, 0.0f, 0.0f, 0.0f}) {
    hand.add_aim_orientation(w);
    hand.add_grip_orientation(w);
  }
  hand.set_trigger(1);
  return message;
}

TEST_F(Gate, ViewScopeIgnoresInput) {
  RawClient looks(channel(token(v1::VIEW))), touches(channel(token(v1::INTERACT)));
  ASSERT_TRUE(looks.join().ok());
  ASSERT_TRUE(touches.join().ok());
  EXPECT_TRUE(looks.joined.view_only());
  EXPECT_FALSE(touches.joined.view_only());
  looks.open();
  publish(1);
  ASSERT_EQ(looks.read().tick(), 1u);
  for (uint64_t i = 1; i <= 3; ++i) ASSERT_TRUE(looks.send(squeezing(i)));
  ASSERT_TRUE(looks.acknowledge(1));
  publish(2);
  ASSERT_EQ(looks.read().tick(), 2u);  // its messages were accepted
  touches.open();
  ASSERT_TRUE(touches.send(squeezing(1)));
  ASSERT_TRUE(inputs_.wait_heard(1));
  EXPECT_EQ(inputs_.received(), 1u);
}

// A session belongs to its token: its id is useless with another token.
TEST_F(Gate, SessionIsBoundToItsToken) {
  RawClient owner(channel(token(v1::INTERACT))), thief(channel(token(v1::VIEW)));
  ASSERT_TRUE(owner.join().ok());
  ASSERT_TRUE(thief.join(kProtocolVersion, owner.joined.session_id()).ok());
  EXPECT_NE(thief.joined.session_id(), owner.joined.session_id());
  thief.joined.set_session_id(owner.joined.session_id());
  thief.open();
  EXPECT_EQ(thief.finish().error_code(), grpc::StatusCode::NOT_FOUND);
  owner.open();
  publish(1);
  EXPECT_EQ(owner.read().tick(), 1u);
}

TEST_F(Gate, ReportsProtocolVersionOnlyToAuthorisedCallers) {
  RawClient good(channel(token(v1::VIEW))), bad(channel("livegs_wrong"));
  EXPECT_EQ(good.join(kProtocolVersion + 1).error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(bad.join(kProtocolVersion + 1).error_code(), grpc::StatusCode::UNAUTHENTICATED);
}

TEST_F(Gate, KickedClientGetsTheReasonAndMayRejoin) {
  RawClient client(channel(token(v1::VIEW)));
  ASSERT_TRUE(client.join().ok());
  client.open();
  publish(1);
  ASSERT_EQ(client.read().tick(), 1u);
  const auto admin = v1::Admin::NewStub(channel(token(v1::ADMIN)));
  const auto kick = [&](const std::string& session) {
    grpc::ClientContext context;
    set_patience(context);
    v1::KickClientRequest request;
    request.set_session(session);
    request.set_reason("lunch");
    v1::KickClientReply reply;
    return admin->KickClient(&context, request, &reply);
  };
  EXPECT_EQ(kick(client.joined.session_id().substr(0, 3)).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(kick("zzzz").error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_TRUE(kick(client.joined.session_id().substr(0, 8)).ok());
  const grpc::Status status = client.finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::PERMISSION_DENIED);
  EXPECT_NE(status.error_message().find("lunch"), std::string::npos) << status.error_message();
  EXPECT_TRUE(client.join().ok());
}

TEST_F(Gate, LimitsTheCallRateOfEachToken) {
  CallAuthoriser gate(security_->tokens());
  const auto ask = [&](const std::string& secret) {
    const std::string value = "Bearer " + secret, path = "/livegs.v1.LiveGs/GetServerInfo";
    const grpc::AuthMetadataProcessor::InputMetadata metadata = {{"authorization", value}, {":path", path}};
    return gate.Process(metadata, nullptr, nullptr, nullptr).error_code();
  };
  const std::string busy = token(v1::ADMIN), other = token(v1::VIEW);
  int refused = 0;
  for (int i = 0; i < 100'000 && refused == 0; ++i)
    refused += ask(busy) == grpc::StatusCode::RESOURCE_EXHAUSTED ? 1 : 0;
  EXPECT_EQ(refused, 1);
  EXPECT_EQ(ask(other), grpc::StatusCode::OK);
}

// A call with two tokens counts as a call without a token.
TEST_F(Gate, RefusesCallsWithTwoTokens) {
  CallAuthoriser gate(security_->tokens());
  const std::string good = "Bearer " + token(v1::ADMIN), basic = "Basic " + good.substr(7);
  const std::string path = "/livegs.v1.LiveGs/Join";
  using Metadata = grpc::AuthMetadataProcessor::InputMetadata;
  for (const Metadata& metadata :
       {Metadata{{":path", path}, {"authorization", good}, {"authorization", good}},
        Metadata{{":path", path}, {"authorization", basic}}, Metadata{{":path", path}}, Metadata{}}) {
    EXPECT_EQ(gate.Process(metadata, nullptr, nullptr, nullptr).error_code(),
              grpc::StatusCode::UNAUTHENTICATED);
  }
}

// A connection without a handshake is closed after three seconds; without the limit it takes two minutes.
TEST_F(Gate, ClosesConnectionsWithoutHandshake) {
  const int silent = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<uint16_t>(server_->port()));
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(::connect(silent, reinterpret_cast<sockaddr*>(&to), sizeof to), 0);
  pollfd news{silent, POLLIN, 0};
  char byte = 0;
  ASSERT_EQ(::poll(&news, 1, 60'000), 1);
  EXPECT_LE(::recv(silent, &byte, 1, 0), 0);
  ::close(silent);
}

TEST_F(GrpcServerTest, EndsStreamsThatFlood) {
  open();
  RawClient client(server_->port()), other(server_->port());
  ASSERT_TRUE(client.join().ok());
  ASSERT_TRUE(other.join().ok());
  client.open();
  other.open();
  for (int i = 0; i < 200'000 && client.send({}); ++i) {
  }
  const grpc::Status status = client.finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_NE(status.error_message().find("more than 1000 a second"), std::string::npos)
      << status.error_message();
  publish(1);
  EXPECT_EQ(other.read().tick(), 1u);
}

TEST_F(GrpcServerTest, WithoutTlsAllButTokensIsAllowed) {
  open();
  const auto admin = v1::Admin::NewStub(channel_to(server_->port()));
  grpc::ClientContext first, second;
  set_patience(first);
  set_patience(second);
  v1::ServerStatus status;
  EXPECT_TRUE(admin->GetStatus(&first, {}, &status).ok());
  EXPECT_FALSE(status.secure());
  v1::AddTokenReply token;
  EXPECT_EQ(admin->AddToken(&second, {}, &token).error_code(), grpc::StatusCode::FAILED_PRECONDITION);
}

}  // namespace
}  // namespace livegs
