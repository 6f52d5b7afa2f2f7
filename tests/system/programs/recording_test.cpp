// SPDX-License-Identifier: Apache-2.0
// Recording, inspection, playback and re-simulation of a session by the programs.
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <fstream>

#include "splat/image.h"
#include "system/programs/programs_fixture.h"

namespace livegs {
namespace {

class Recordings : public Programs {
 protected:
  std::string file() { return (folder_ / "session.lvgrec").string(); }
  Program replay(std::vector<std::string> more = {}) {
    std::vector<std::string> words = {LIVEGS_TOOL, "ctl", "replay", file()};
    words.insert(words.end(), more.begin(), more.end());
    return Program(words);
  }
};

TEST_F(Recordings, CanBeInspectedPlayedAndSimulatedAgain) {
  Program server(server_words({"--record", file(), "--record-assets", "--wait-for-client"}));
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  Program client(client_words(port, {"--seconds", "2", "--poke", "cube", "--no-video", "--every", "0"}));
  ASSERT_EQ(client.wait(), 0) << client.err();
  server.send(SIGTERM);
  ASSERT_EQ(server.wait(), 0) << server.err();

  Program summary = replay();
  ASSERT_EQ(summary.wait(), 0) << summary.err();
  EXPECT_NE(summary.out().find("of boxes.scene.json"), std::string::npos) << summary.out();
  EXPECT_NE(summary.out().find("3 initially"), std::string::npos) << summary.out();
  EXPECT_EQ(summary.out().find(" 0 hand samples"), std::string::npos) << summary.out();
  Program verified = replay({"--verify"});
  ASSERT_EQ(verified.wait(), 0) << verified.out() << verified.err();
  EXPECT_EQ(verified.out().find("bit-equal"), 0u) << verified.out();

  // Without server and cache: the recording contains the assets.
  Program watched({LIVEGS_CLIENT, "--display", "offscreen", "--replay", file(), "--from", "1", "--output",
                   folder_ / "watched", "--cache", folder_ / "empty", "--size", "160x120", "--no-video",
                   "--every", "10", "--threads", "1"});
  ASSERT_EQ(watched.wait(), 0) << watched.err();
  const auto last = read_png(folder_ / "watched/last.png");
  ASSERT_TRUE(last);
  size_t bright = 0;  // pixels of floor and cube
  for (int i = 0; i < last->width * last->height; ++i) bright += last->pixels[4 * i + 2] > 0.3f;
  EXPECT_GT(bright, 2000u);
  EXPECT_NE(watched.out().find("from 1.0 s"), std::string::npos) << watched.out();

  EXPECT_NE(summary.out().find("checksums  valid\n"), std::string::npos) << summary.out();
  Program beyond({LIVEGS_CLIENT, "--display", "offscreen", "--replay", file(), "--from", "500", "--output",
                  folder_ / "beyond"});
  EXPECT_EQ(beyond.wait(), 2);
  expect_one_line(beyond, "--from 500: " + file() + " is ");

  // A changed byte is reported at any position.
  std::filesystem::copy_file(file(), folder_ / "flipped.lvgrec");
  {
    std::fstream flipped(folder_ / "flipped.lvgrec", std::ios::in | std::ios::out | std::ios::binary);
    const auto middle = static_cast<std::streamoff>(std::filesystem::file_size(file()) / 2);
    flipped.seekg(middle);
    const char changed = static_cast<char>(flipped.get() ^ 1);
    flipped.seekp(middle);
    flipped.put(changed);
  }
  Program flipped({LIVEGS_TOOL, "ctl", "replay", folder_ / "flipped.lvgrec"});
  EXPECT_EQ(flipped.wait(), 2);
  EXPECT_NE(flipped.err().find("wrong checksum"), std::string::npos) << flipped.err();
  EXPECT_EQ(flipped.out().find("checksums  valid"), std::string::npos) << flipped.out();

  // A truncated file keeps the data before the cut.
  std::filesystem::copy_file(file(), folder_ / "cut.lvgrec");
  std::filesystem::resize_file(folder_ / "cut.lvgrec", std::filesystem::file_size(file()) / 2);
  Program cut({LIVEGS_TOOL, "ctl", "replay", folder_ / "cut.lvgrec"});
  ASSERT_EQ(cut.wait(), 0) << cut.err();
  EXPECT_NE(cut.out().find("incomplete"), std::string::npos) << cut.out();
}

TEST_F(Recordings, StartAndStopOnARunningServer) {
  Program server(server_words());
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  const auto ctl = [&](std::vector<std::string> more) {
    std::vector<std::string> words = {LIVEGS_TOOL, "ctl", "--server", "127.0.0.1:" + port};
    words.insert(words.end(), more.begin(), more.end());
    return Program(words);
  };
  Program none = ctl({"record", "stop"});
  EXPECT_EQ(none.wait(), 2);
  EXPECT_NE(none.err().find("none is in progress"), std::string::npos) << none.err();
  Program begun = ctl({"record", "start", file()});
  ASSERT_EQ(begun.wait(), 0) << begun.err();
  Program again = ctl({"record", "start", folder_ / "other.lvgrec"});
  EXPECT_EQ(again.wait(), 2);
  EXPECT_NE(again.err().find("already in progress"), std::string::npos) << again.err();
  Program status = ctl({"status"});
  ASSERT_EQ(status.wait(), 0);
  EXPECT_NE(status.out().find(": recording, "), std::string::npos) << status.out();
  Program client(client_words(port, {"--seconds", "0.5", "--no-video", "--every", "0"}));
  ASSERT_EQ(client.wait(), 0) << client.err();
  Program ended = ctl({"record", "stop"});
  ASSERT_EQ(ended.wait(), 0) << ended.err();
  EXPECT_EQ(ended.out().find("recorded "), 0u) << ended.out();
  Program summary = replay();
  ASSERT_EQ(summary.wait(), 0) << summary.err();
  EXPECT_EQ(summary.out().find("incomplete"), std::string::npos) << summary.out();
}

TEST_F(Recordings, RefusesOtherFilesInOneLine) {
  folder_.write("session.lvgrec", "not one at all");
  Program summary = replay();
  EXPECT_EQ(summary.wait(), 2);
  expect_one_line(summary, "session.lvgrec: is not a recording");
  Program watched({LIVEGS_CLIENT, "--display", "offscreen", "--replay", file()});
  EXPECT_EQ(watched.wait(), 2);
  expect_one_line(watched, "session.lvgrec: is not a recording");
  Program server(server_words({"--record", file()}));
  EXPECT_EQ(server.wait(), 2);
  EXPECT_NE(server.err().find("already exists"), std::string::npos) << server.err();
}

}  // namespace
}  // namespace livegs
