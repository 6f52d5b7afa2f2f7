// SPDX-License-Identifier: Apache-2.0
// A server in a fleet: its calls to the sidecar of Agones, its end, and tokens that are signed for it.
#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>

#include "server/session/fleet/agones_sidecar.h"
#include "system/programs/programs_fixture.h"

namespace livegs {
namespace {

// terminationGracePeriodSeconds of deploy/kubernetes/fleet/fleet.yaml: after it, Kubernetes kills the server.
constexpr double kGracePeriod_s = 30;

class FleetPrograms : public Programs {
 protected:
  FleetPrograms() { use_port(sidecar_.port()); }
  ~FleetPrograms() override { ::unsetenv("AGONES_SDK_HTTP_PORT"); }
  static void use_port(int port) { ::setenv("AGONES_SDK_HTTP_PORT", std::to_string(port).c_str(), 1); }
  std::vector<std::string> fleet_words(std::vector<std::string> more = {}) {
    more.insert(more.end(), {"--fleet", "agones"});
    return server_words(std::move(more));
  }
  AgonesSidecar sidecar_;
};

TEST_F(FleetPrograms, IsReadyAllocatedAndShutDownInThisOrder) {
  Program server(fleet_words({"--clients", "16"}));
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  ASSERT_TRUE(sidecar_.wait_for("POST /ready"));
  ASSERT_TRUE(sidecar_.wait_for("POST /health", 2));
  EXPECT_EQ(sidecar_.count("POST /allocate"), 0u);
  Program client(client_words(port, {"--seconds", "0", "--no-video", "--every", "0"}));
  ASSERT_TRUE(sidecar_.wait_for("POST /allocate")) << client.err();
  EXPECT_TRUE(sidecar_.wait_for_body("PATCH /v1beta1/counters/people", R"({"capacity":"16","count":"1"})"));
  const int64_t begun_ns = now_ns();
  server.send(SIGTERM);
  EXPECT_EQ(server.wait(), 0) << server.err();
  EXPECT_LT(seconds_from_ns(now_ns() - begun_ns), kGracePeriod_s);  // with a person and no next address
  EXPECT_EQ(sidecar_.calls().back().what, "POST /shutdown");
  EXPECT_EQ(sidecar_.count("POST /ready"), 1u);
  EXPECT_EQ(sidecar_.count("POST /allocate"), 1u);
}

TEST_F(FleetPrograms, EndsWhenItIsEmpty) {
  Program server(fleet_words({"--fleet-empty-s", "1"}));
  ASSERT_TRUE(sidecar_.wait_for("POST /ready")) << server.err();
  sidecar_.set_state("Allocated");
  EXPECT_EQ(server.wait(), 0) << server.err();
  EXPECT_EQ(sidecar_.count("POST /shutdown"), 1u);
  EXPECT_NE(server.err().find("no person for 1 s"), std::string::npos) << server.err();
}

TEST_F(FleetPrograms, EndsWithOneLineWithoutASidecar) {
  use_port(1);
  Program server(fleet_words());
  EXPECT_EQ(server.wait(), 1);
  expect_one_line(server, "--fleet agones: no sidecar replied at http://localhost:1 within 30 s");
}

TEST_F(FleetPrograms, EndsInOrderWhileItWaitsForASidecar) {
  use_port(1);
  Program server(fleet_words({"--verbose"}));
  ASSERT_TRUE(server.says_often("agones: GET /gameserver", 2)) << server.err();
  server.send(SIGTERM);
  EXPECT_EQ(server.wait(), 0) << server.err();
}

TEST_F(FleetPrograms, RefusesUnusableOptions) {
  const auto expect_refused = [&](std::vector<std::string> more, const std::string& message) {
    Program server(server_words(std::move(more)));
    EXPECT_EQ(server.wait(), 2) << message;
    EXPECT_NE(server.err().find(message), std::string::npos) << server.err();
  };
  const std::string key = folder_.write("open.key", std::string(40, 'k') + "\n");
  const std::string state = folder_ / "state";
  expect_refused({"--fleet-key", key}, "needs TLS");
  expect_refused({"--fleet-key", key, "--tls", "on", "--state-dir", state}, "add --server-name NAME");
  expect_refused({"--fleet", "agones", "--wait-for-client"}, "--wait-for-client");
  expect_refused({"--fleet-empty-s", "5"}, "--fleet");
  ::setenv("AGONES_SDK_HTTP_PORT", "http", 1);
  expect_refused({"--fleet", "agones"}, "AGONES_SDK_HTTP_PORT: \"http\" is not a port");
}

// Two servers of a fleet with one certificate and key. The first one is drained, and annotated only then.
TEST_F(FleetPrograms, SendsClientsToTheNextServerWithATokenForIt) {
  const auto tool = [&](std::vector<std::string> words) {
    words.insert(words.begin(), LIVEGS_TOOL);
    Program program(std::move(words));
    EXPECT_EQ(program.wait(), 0) << program.err();
    return program.out();
  };
  const std::string key = folder_ / "fleet.key", state = folder_ / "a";
  tool({"token", "--new-key", key});
  const auto sign = [&](const std::string& server, const std::string& valid_s) {
    return folder_.write(server + valid_s, tool({"token", "--key", key, "--server", server, "--name", "ada",
                                                 "--valid-s", valid_s}));
  };
  Program first(fleet_words({"--tls", "on", "--state-dir", state, "--fleet-key", key}));
  const std::string port = first.first_line();
  ASSERT_NE(port, "") << first.err();
  Program second(
      server_words({"--tls", "on", "--state-dir", folder_ / "b", "--certificate", state + "/server.crt",
                    "--key", state + "/server.key", "--fleet-key", key, "--server-name", "room-b"}));
  const std::string next_port = second.first_line();
  ASSERT_NE(next_port, "") << second.err();
  const std::string status = tool({"ctl", "--server", "127.0.0.1:" + port, "--state-dir", state, "status"});
  const size_t begun = status.find("pairing code  ");
  ASSERT_NE(begun, std::string::npos) << status;
  const std::string code = status.substr(begun + 14, 29);
  const auto viewer = [&](const std::string& at, const std::string& token, const std::string& pins) {
    return client_words(at, {"--seconds", "0", "--no-video", "--every", "0", "--pair", code, "--token-file",
                             token, "--state-dir", folder_ / pins});
  };

  Program lost(viewer(port, sign("room-b", "600"), "lost"));
  EXPECT_EQ(lost.wait(), 1);
  EXPECT_NE(lost.err().find("not known to this server"), std::string::npos) << lost.err();
  EXPECT_TRUE(first.says("is for server \"room-b\", not for \"room-x7k2p\"")) << first.err();

  Program client(viewer(port, sign("room-x7k2p", "600"), "pins"));
  ASSERT_TRUE(sidecar_.wait_for("POST /allocate")) << client.err();
  ASSERT_TRUE(first.says("streaming to")) << first.err();
  first.send(SIGTERM);
  ASSERT_TRUE(first.says("waiting at most 10 s for the annotation livegs.io/next-address")) << first.err();
  sidecar_.set_annotations(R"("livegs.io/next-address": "127.0.0.1:)" + next_port +
                           R"(", "livegs.io/next-server": "room-b")");
  EXPECT_EQ(first.wait(), 0) << first.err();
  EXPECT_TRUE(second.says("streaming to")) << client.err();
  EXPECT_NE(second.err().find("with the token \"ada\", interact"), std::string::npos) << second.err();
  EXPECT_TRUE(client.says("continuing at 127.0.0.1:" + next_port)) << client.err();
  client.send(SIGTERM);
  EXPECT_EQ(client.wait(), 0) << client.err();
}

}  // namespace
}  // namespace livegs
