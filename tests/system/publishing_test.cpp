// SPDX-License-Identifier: Apache-2.0
// Frames that are published, and who watches them, as whole programs.
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>

#include "system/programs_fixture.h"

namespace livegs {
namespace {

TEST_F(Programs, ASpectatorSeesWhatIsPublished) {
  Program server(server_words({"--publish", "tcp://127.0.0.1:0"}));
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  const std::string said = server.err(), key = "publishing on ";
  const size_t begin = said.find(key) + key.size();
  const std::string where = said.substr(begin, said.find('\n', begin) - begin);
  ASSERT_EQ(where.find("tcp://127.0.0.1:"), 0u) << said;
  Program spectator(client_words(port, {"--subscribe", where, "--seconds", "1", "--no-video", "--every", "0"}));
  ASSERT_EQ(spectator.wait(), 0) << spectator.err();
  EXPECT_NE(spectator.out().find("spectator of " + where + ": 3 objects"), std::string::npos) << spectator.out();
  EXPECT_TRUE(std::filesystem::exists(folder_ / "view/last.png"));
  server.send(SIGTERM);
  ASSERT_EQ(server.wait(), 0) << server.err();
  EXPECT_NE(server.out().find(" 0 sessions"), std::string::npos) << server.out();
}

TEST_F(Programs, PublishesOnThisMachineOnly) {
  Program server(server_words({"--publish", "tcp://0.0.0.0:9782"}));
  EXPECT_EQ(server.wait(), 2);
  expect_one_line(server, "--publish tcp://0.0.0.0:9782: frames are published without tokens");
}

}  // namespace
}  // namespace livegs
