// SPDX-License-Identifier: Apache-2.0
// Publishing server and spectators as programs.
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <filesystem>
#include <thread>
#include <utility>

#include "system/programs/programs_fixture.h"

namespace livegs {
namespace {

TEST_F(Programs, SpectatorSeesPublishedFrames) {
  Program server(server_words({"--publish", "tcp://127.0.0.1:0"}));
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  const std::string said = server.err(), key = "publishing on ";
  const size_t begin = said.find(key) + key.size();
  const std::string where = said.substr(begin, said.find('\n', begin) - begin);
  ASSERT_EQ(where.find("tcp://127.0.0.1:"), 0u) << said;
  Program spectator(
      client_words(port, {"--subscribe", where, "--seconds", "1", "--no-video", "--every", "0"}));
  ASSERT_EQ(spectator.wait(), 0) << spectator.err();
  EXPECT_NE(spectator.out().find("spectator of " + where + ": 3 objects"), std::string::npos)
      << spectator.out();
  EXPECT_TRUE(std::filesystem::exists(folder_ / "view/last.png"));
  server.send(SIGTERM);
  ASSERT_EQ(server.wait(), 0) << server.err();
  EXPECT_NE(server.out().find(" 0 sessions"), std::string::npos) << server.out();
}

// Nothing is published at these addresses. ZeroMQ itself retries without limit.
TEST_F(Programs, SpectatorWithoutPublisherTimesOut) {
  Program server(server_words());
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  const std::pair<std::string, std::string> places[] = {
      {"tcp://127.0.0.1:1", "use the address printed by livegs-server --publish"},
      {"tcp://192.0.2.1:9782", "use livegs-client HOST:PORT for a server on another machine"}};
  for (const auto& [where, why] : places) {
    Program spectator(client_words(port, {"--subscribe", where, "--seconds", "60", "--connect-timeout", "0.8",
                                          "--renderer", "cpu", "--no-video", "--every", "0"}));
    EXPECT_EQ(spectator.wait(), 1) << spectator.err();
    expect_one_line(spectator, "--subscribe " + where + ": nothing was published there within 0.");
    EXPECT_NE(spectator.err().find(why), std::string::npos) << spectator.err();
  }
}

TEST_F(Programs, SpectatorReportsTheLossOfItsServer) {
  Program server(server_words({"--publish", "tcp://127.0.0.1:0"}));
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  const std::string said = server.err(), key = "publishing on ";
  const size_t at = said.find(key) + key.size();
  const std::string where = said.substr(at, said.find('\n', at) - at);
  Program spectator(
      client_words(port, {"--subscribe", where, "--seconds", "0", "--reconnect", "0", "--every", "1"}));
  const auto pictures = [&] {
    std::error_code none_yet;
    const auto files = std::filesystem::directory_iterator(folder_ / "view", none_yet);
    return std::count_if(begin(files), end(files), [](const auto& file) {
      return file.path().filename().string().starts_with("frame_");
    });
  };
  for (int i = 0; i < 600 && pictures() == 0; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  ASSERT_GT(pictures(), 0) << spectator.err();
  server.send(SIGKILL);
  server.wait();
  EXPECT_EQ(spectator.wait(), 1) << spectator.err();
  const std::string err = spectator.err();
  EXPECT_NE(err.find("--subscribe " + where + ": connection lost: nothing was published for "),
            std::string::npos)
      << err;
  EXPECT_EQ(err.find("connection lost"), err.rfind("connection lost")) << err;
  EXPECT_NE(spectator.out().find("spectator of " + where), std::string::npos) << spectator.out();
}

TEST_F(Programs, RefusesToPublishToOtherMachines) {
  Program server(server_words({"--publish", "tcp://0.0.0.0:9782"}));
  EXPECT_EQ(server.wait(), 2);
  expect_one_line(server,
                  "--publish tcp://0.0.0.0:9782: is not local, and frames are published without tokens");
}

}  // namespace
}  // namespace livegs
