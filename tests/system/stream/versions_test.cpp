// SPDX-License-Identifier: Apache-2.0
// Server and client with different protocol versions. One side is the program, the other is simulated by the
// test.
#include <gtest/gtest.h>

#include <atomic>

#include "client/stream/session/scripted_server.h"
#include "server/session/rpc/raw_client.h"
#include "system/programs/programs_fixture.h"

namespace livegs {
namespace {

class OtherVersions : public Programs {};

TEST_F(OtherVersions, ClientPrintsTheServersErrorOnce) {
  ScriptedServer server;
  std::atomic<int> joins{0};
  server.on_join = [&](int, const v1::JoinRequest& request, v1::JoinReply&) {
    ++joins;
    EXPECT_EQ(request.protocol_version(), kProtocolVersion);
    return grpc::Status(grpc::StatusCode::FAILED_PRECONDITION,
                        "this server speaks another version; update the older one");
  };
  server.start();
  Program client({LIVEGS_CLIENT, server.address(), "--display", "offscreen", "--output", folder_ / "view",
                  "--cache", folder_ / "cache", "--seconds", "1", "--no-video"});
  EXPECT_EQ(client.wait(), 1);
  expect_one_line(client, "this server speaks another version; update the older one");
  EXPECT_EQ(joins, 1);
}

TEST_F(OtherVersions, ServerReportsOnlyBothVersions) {
  Program server(server_words());
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  for (const uint32_t version : {kProtocolVersion - 1, kProtocolVersion + 1, 0u}) {
    RawClient client(std::stoi(port));
    const grpc::Status status = client.join(version);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
    for (const std::string& named :
         {std::to_string(version), std::to_string(kProtocolVersion), std::string("update the older one")})
      EXPECT_NE(status.error_message().find(named), std::string::npos) << status.error_message();
    EXPECT_EQ(status.error_message().find("boxes"), std::string::npos) << status.error_message();
    EXPECT_EQ(client.joined.ByteSizeLong(), 0u);
  }
  Program client(client_words(port, {"--seconds", "0.2", "--no-video"}));
  EXPECT_EQ(client.wait(), 0) << client.err();
}

}  // namespace
}  // namespace livegs
