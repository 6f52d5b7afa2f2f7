// SPDX-License-Identifier: Apache-2.0
// livegs-server and livegs-client as programs: their output and exit codes, normally and after faults.
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "patience.h"
#include "splat/image.h"
#include "system/programs/programs_fixture.h"

namespace livegs {
namespace {

TEST_F(Programs, StreamPokeAndEndWithoutErrors) {
  Program server(server_words());
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  Program client(client_words(port, {"--seconds", "2", "--poke", "box", "--every", "10"}));
  EXPECT_EQ(client.wait(), 0) << client.err();
  for (const char* name :
       {"first.png", "last.png", "last_frame.bin", "camera.json", "frames.csv", "timings.csv"}) {
    EXPECT_TRUE(std::filesystem::exists(folder_ / "view" / name)) << name;
  }
  EXPECT_NE(client.out().find("staleness p50"), std::string::npos) << client.out();
  server.send(SIGTERM);
  EXPECT_EQ(server.wait(), 0) << server.err();
  EXPECT_NE(server.out().find("tick p50"), std::string::npos) << server.out();
  EXPECT_NE(server.out().find("box: "), std::string::npos) << server.out();
}

// 18 000 kernels need 4 MB of device memory. With less, the client draws a part of them and prints how many;
// with almost none, it draws with the CPU. It ends normally in both cases.
TEST_F(Programs, FullDeviceReducesKernelsOrUsesTheCpu) {
  Program server(server_words());
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  for (const auto& [megabytes, notice] : {std::pair("2.5", "% of the kernels; the rest is not drawn"),
                                          std::pair("0.05", "rendering continues on the CPU")}) {
    std::vector<std::string> words =
        client_words(port, {"--seconds", "0.5", "--no-video", "--renderer", "vulkan"}, megabytes);
    words.insert(words.begin(), {"/usr/bin/env", std::string("LIVEGS_VULKAN_MEMORY_MB=") + megabytes});
    Program client(words);
    const int code = client.wait();
    if (code == 1 && client.err().find("vulkan: no") != std::string::npos) GTEST_SKIP() << client.err();
    EXPECT_EQ(code, 0) << client.err();
    for (const std::string& said : {client.err(), client.out()})
      EXPECT_NE(said.find(notice), std::string::npos) << megabytes << " MB: " << said;
    EXPECT_TRUE(std::filesystem::exists(folder_ / megabytes / "last.png"));
  }
}

TEST_F(Programs, SecondRunReadsAssetsFromTheCache) {
  Program server(server_words());
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  Program first(client_words(port, {"--seconds", "0.2", "--no-video"}));
  ASSERT_EQ(first.wait(), 0) << first.err();
  EXPECT_EQ(first.out().find(" 0 of "), std::string::npos) << first.out();
  Program second(client_words(port, {"--seconds", "0.2", "--no-video"}));
  ASSERT_EQ(second.wait(), 0) << second.err();
  EXPECT_NE(second.out().find("; 0 of "), std::string::npos) << second.out();
  EXPECT_NE(second.out().find("fetched, 0.0 MB"), std::string::npos) << second.out();
}

TEST_F(Programs, KilledServerEndsClientAndKeepsItsPictures) {
  Program server(server_words());
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  Program client(client_words(port, {"--seconds", "0", "--reconnect", "0.5"}));
  // Frames have arrived by the time a later client has received one second of them.
  ASSERT_TRUE(server.says("streaming to")) << server.err();
  Program probe(client_words(port, {"--seconds", "1", "--no-video"}, "probe"));
  ASSERT_EQ(probe.wait(), 0) << probe.err();
  server.send(SIGKILL);
  EXPECT_EQ(client.wait(), 1) << client.err();
  EXPECT_NE(client.err().find("connection lost"), std::string::npos) << client.err();
  EXPECT_TRUE(read_png(folder_ / "view" / "last.png"));
  EXPECT_GT(std::filesystem::file_size(folder_ / "view" / "frames.csv"), 100u);
}

// The sequence after a server runs out of memory: it aborts, a supervisor restarts it on its port, and
// clients resume.
TEST_F(Programs, ClientsResumeAfterServerRestart) {
  auto server = std::make_unique<Program>(server_words());
  const std::string port = server->first_line();
  ASSERT_NE(port, "") << server->err();
  Program client(client_words(port, {"--seconds", "0", "--no-video", "--reconnect", "60"}));
  Program other(client_words(port, {"--seconds", "0", "--no-video", "--reconnect", "60"}, "other"));
  ASSERT_TRUE(server->says_often(": streaming to", 2)) << server->err();
  const auto expect_frames = [&] {
    Program probe(client_words(port, {"--seconds", "0.5", "--no-video"}, "probe"));
    EXPECT_EQ(probe.wait(), 0) << probe.err();
  };
  expect_frames();
  std::vector<std::string> words = server_words();
  std::replace(words.begin(), words.end(), std::string("127.0.0.1:0"), "127.0.0.1:" + port);
  for (const int signal : {SIGKILL, SIGABRT}) {
    server->send(signal);
    server->wait();
    server = std::make_unique<Program>(words);
    ASSERT_TRUE(server->says_often(": streaming to", 2)) << server->err();
    expect_frames();
  }
  for (Program* one : {&client, &other}) {
    one->send(SIGINT);
    EXPECT_EQ(one->wait(), 0) << one->err();
    // On a busy machine, a client also reconnects after one second without data.
    int disconnects = 0, reconnects = 0;
    const size_t counted = one->out().find(" disconnects, ");
    ASSERT_NE(counted, std::string::npos) << one->out();
    const size_t number = one->out().find_last_not_of("0123456789", counted - 1) + 1;
    ASSERT_EQ(
        std::sscanf(one->out().c_str() + number, "%d disconnects, %d reconnects", &disconnects, &reconnects),
        2)
        << one->out();
    EXPECT_GE(disconnects, 2);
    EXPECT_EQ(reconnects, disconnects);
    // The totals at the end equal those at the join: nothing was fetched again.
    const size_t joined = one->err().find(" assets fetched, ");
    ASSERT_NE(joined, std::string::npos) << one->err();
    EXPECT_NE(one->out().find(one->err().substr(joined, one->err().find('\n', joined) - joined)),
              std::string::npos)
        << one->out();
  }
}

// A suspended client, such as a closed laptop: its session continues, and it delays no other client.
TEST_F(Programs, SuspendedClientIsDroppedAndReconnects) {
  Program server(server_words());
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  Program client(client_words(port, {"--seconds", "0", "--no-video", "--reconnect", "60"}));
  ASSERT_TRUE(server.says("streaming to")) << server.err();
  client.send(SIGSTOP);
  ASSERT_TRUE(server.says("stream ended")) << server.err();
  client.send(SIGCONT);
  ASSERT_TRUE(server.says("joined again")) << server.err();
  client.send(SIGINT);
  EXPECT_EQ(client.wait(), 0) << client.err();
}

// A client continues while another is killed and a later one is served.
TEST_F(Programs, KilledClientDoesNotDisturbOthers) {
  Program server(server_words());
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  Program victim(client_words(port, {"--seconds", "0", "--no-video"}, "victim"));
  Program other(client_words(port, {"--seconds", "0", "--no-video"}));
  ASSERT_TRUE(server.says_often(": streaming to", 2)) << server.err();
  Program before(client_words(port, {"--seconds", "0.5", "--no-video"}, "before"));
  ASSERT_EQ(before.wait(), 0) << before.err();
  victim.send(SIGKILL);
  ASSERT_TRUE(server.says(": stream broke")) << server.err();
  Program after(client_words(port, {"--seconds", "1", "--no-video"}, "after"));
  ASSERT_EQ(after.wait(), 0) << after.err();
  other.send(SIGINT);
  EXPECT_EQ(other.wait(), 0) << other.err();
  const std::vector<uint64_t> later = ticks_of("after"), own = ticks_of("view");
  ASSERT_GT(later.size(), 1u);
  const auto shown = static_cast<size_t>(std::count_if(
      own.begin(), own.end(), [&](uint64_t tick) { return tick >= later.front() && tick <= later.back(); }));
  EXPECT_GT(shown, 0u);
}

TEST_F(Programs, ServerNotifiesClientsAtItsEnd) {
  Program server(server_words({"--seconds", "3"}));
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  Program client(client_words(port, {"--seconds", "0", "--no-video"}));
  EXPECT_EQ(client.wait(), 0) << client.err();
  EXPECT_NE(client.err().find("the time limit is reached"), std::string::npos) << client.err();
  EXPECT_EQ(server.wait(), 0) << server.err();
}

// Termination by systemd or a person: reading clients are notified, suspended clients are not waited for, and
// the port is free for the next server.
TEST_F(Programs, DrainsClientsAndReleasesPortOnSigterm) {
  Program server(server_words());
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  Program stopped(client_words(port, {"--seconds", "0", "--no-video"}, "stopped"));
  ASSERT_TRUE(server.says("streaming to")) << server.err();
  stopped.send(SIGSTOP);
  Program client(client_words(port, {"--seconds", "0", "--no-video"}));
  ASSERT_TRUE(server.says_often(": streaming to", 2)) << server.err();
  server.send(SIGTERM);
  EXPECT_EQ(server.wait(), 0) << server.err();
  EXPECT_NE(server.out().find("tick p50"), std::string::npos) << server.out();
  EXPECT_EQ(client.wait(), 0) << client.err();
  EXPECT_NE(client.err().find("stopped by a signal (Terminated)"), std::string::npos) << client.err();
  std::vector<std::string> words = server_words();
  std::replace(words.begin(), words.end(), std::string("127.0.0.1:0"), "127.0.0.1:" + port);
  Program next(words);
  EXPECT_EQ(next.first_line(), port) << next.err();
}

TEST_F(Programs, InterruptedClientWritesItsOutput) {
  Program server(server_words());
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  Program client(client_words(port, {"--seconds", "0", "--no-video"}));
  ASSERT_TRUE(server.says("streaming to")) << server.err();
  Program probe(client_words(port, {"--seconds", "1", "--no-video"}, "probe"));
  ASSERT_EQ(probe.wait(), 0) << probe.err();
  client.send(SIGINT);
  EXPECT_EQ(client.wait(), 0) << client.err();
  EXPECT_TRUE(std::filesystem::exists(folder_ / "view" / "timings.csv"));
}

TEST_F(Programs, PortInUseGivesOneLineAndCodeOne) {
  Program first(server_words());
  const std::string port = first.first_line();
  ASSERT_NE(port, "") << first.err();
  Program second({LIVEGS_SERVER, folder_ / "boxes.scene.json", "--listen", "127.0.0.1:" + port});
  EXPECT_EQ(second.wait(), 1);
  expect_one_line(second, "the port is in use");
  Program client(client_words(port, {"--seconds", "0.2", "--no-video"}));  // the first server keeps running
  EXPECT_EQ(client.wait(), 0) << client.err();
}

TEST_F(Programs, MissingSceneGivesOneLineAndCodeTwo) {
  Program server({LIVEGS_SERVER, folder_ / "absent.scene.json", "--listen", "127.0.0.1:0"});
  EXPECT_EQ(server.wait(), 2);
  expect_one_line(server, "absent.scene.json");
}

TEST_F(Programs, DeadlineIsCheckedBeforeLoading) {
  for (const std::string seconds : {"0", "0.5", "3601", "soon", "90"}) {
    Program server({LIVEGS_SERVER, folder_ / "absent.scene.json", "--listen", "127.0.0.1:0",
                    "--model-deadline", seconds});
    EXPECT_EQ(server.wait(), 2) << seconds;
    const bool refused = server.err().find("--model-deadline") != std::string::npos;
    EXPECT_EQ(refused, seconds != "90") << server.err();
    EXPECT_NE(refused, server.err().find("absent.scene.json") != std::string::npos) << server.err();
  }
}

TEST_F(Programs, AbsentServerGivesOneLineAndCodeOne) {
  Program client(client_words("1", {"--connect-timeout", "0.3"}));
  EXPECT_EQ(client.wait(), 1);
  expect_one_line(client, "127.0.0.1:1: no server answers");
}

TEST_F(Programs, RefusesUnknownDisplay) {
  Program client({LIVEGS_CLIENT, "127.0.0.1:1", "--display", "hologram"});
  EXPECT_EQ(client.wait(), 2);
  EXPECT_NE(client.err().find("offscreen"), std::string::npos) << client.err();
}

// Options that a display does not support are refused with one line before anything is opened.
TEST_F(Programs, UnsupportedOptionGivesOneLineAndCodeTwo) {
  const std::string script = folder_.write("hands.json", "{}");
  struct Case {
    std::vector<std::string> words;
    std::string named, remedy;
  };
  const std::string force = "cube:0,0,0:1,0,0:1";
  const std::vector<Case> cases = {
      {{"--display", "openxr", "--script", script}, "--script:", "--display offscreen"},
      {{"--display", "openxr", "--poke", "box"}, "--poke:", "--display window"},
      {{"--display", "openxr", "--force", force}, "--force:", "--display window"},
      {{"--display", "openxr", "--select", "box"}, "--select:", "--display window"},
      {{"--display", "openxr", "--output", folder_ / "out"}, "--output:", "--display window"},
      {{"--display", "openxr", "--every", "5"}, "--every:", "--display window"},
      {{"--display", "openxr", "--size", "640x480"}, "--size:", "remove the option"},
      {{"--display", "openxr", "--no-video"}, "--no-video:", "--display offscreen"},
      {{"--display", "openxr", "--video-rate", "60"}, "--video-rate:", "--display offscreen"},
      {{"--display", "offscreen", "--full-size"}, "--full-size:", "--display window"},
      {{"--display", "window", "--no-video"}, "--no-video:", "--display offscreen"},
      {{"--display", "window", "--video-rate", "60"}, "--video-rate:", "--display offscreen"},
      {{"--select", "box", "--no-video"}, "--no-video:", "--display offscreen"},
      {{"--display", "window", "--script", script}, "--script:", "--display offscreen"},
      {{"--select", "box", "--script", script}, "--script:", "--display offscreen"},
      {{"--display", "offscreen", "--select", "box"}, "--select:", "--display window"},
      {{"--subscribe", "tcp://127.0.0.1:1", "--poke", "box"}, "--poke:", "remove the option"}};
  for (const Case& one : cases) {
    std::vector<std::string> words = {LIVEGS_CLIENT, "127.0.0.1:1"};
    words.insert(words.end(), one.words.begin(), one.words.end());
    Program client(words);
    EXPECT_EQ(client.wait(), 2);
    expect_one_line(client, one.named);
    expect_one_line(client, one.remedy);
  }
}

// With --renderer vulkan and no device, the error names the package to install; otherwise the CPU draws.
TEST_F(Programs, MissingVulkanDriverNamesThePackage) {
  Program server(server_words());
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  const auto words = [&](const char* renderer) {
    std::vector<std::string> all = {"/usr/bin/env", "VK_ICD_FILENAMES=/nowhere/driver.json"};
    const std::vector<std::string> client =
        client_words(port, {"--seconds", "0.2", "--no-video", "--renderer", renderer});
    all.insert(all.end(), client.begin(), client.end());
    return all;
  };
  Program vulkan(words("vulkan"));
  EXPECT_EQ(vulkan.wait(), 1);
  expect_one_line(vulkan, "install the GPU's driver, or the package mesa-vulkan-drivers");
  Program any(words("auto"));
  EXPECT_EQ(any.wait(), 0) << any.err();
  EXPECT_NE(any.err().find("renderer: cpu: vulkan: no "), std::string::npos) << any.err();
}

// Prints the remedy for the headset, then the one for the window.
TEST_F(Programs, OpensAWindowWithoutAHeadset) {
  Program client({"/usr/bin/env", "DISPLAY=", "XR_RUNTIME_JSON=/nowhere/at_all.json", LIVEGS_CLIENT,
                  "127.0.0.1:1", "--display", "openxr"});
  EXPECT_EQ(client.wait(), 1);
  const std::string err = client.err();
  EXPECT_EQ(std::count(err.begin(), err.end(), '\n'), 2) << err;
  EXPECT_NE(err.find("XR_RUNTIME_JSON"), std::string::npos) << err;
  EXPECT_NE(err.find("--display offscreen"), std::string::npos) << err;
}

TEST_F(Programs, PokeAtUnknownObjectListsTheObjects) {
  Program server(server_words());
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  Program client(client_words(port, {"--poke", "hat"}));
  EXPECT_EQ(client.wait(), 2);
  expect_one_line(client, "box, cube");
}

// --help names the kind of each value and gives commands that can be copied.
TEST(Help, HasKindsGroupsAndExamples) {
  const std::vector<std::vector<std::string>> programs = {
      {LIVEGS_SERVER, "Clients:", "--listen HOST:PORT"},
      {LIVEGS_CLIENT, "Connection:", "--size WxH"},
      {LIVEGS_TOOL, "Server:", "--server HOST:PORT", "ctl"},
      {LIVEGS_TOOL, "Output:", "-o,--output FOLDER", "simulate"}};
  for (const auto& one : programs) {
    std::vector<std::string> words = {one[0]};
    words.insert(words.end(), one.begin() + 3, one.end());
    words.push_back("--help");
    Program program(words);
    ASSERT_EQ(program.wait(), 0) << program.err();
    const std::string text = program.out();
    EXPECT_NE(text.find("\n" + one[1] + "\n"), std::string::npos) << text;
    EXPECT_NE(text.find("  " + one[2] + " "), std::string::npos) << text;
    const size_t examples = text.find("Examples:");
    ASSERT_NE(examples, std::string::npos) << text;
    const std::string commands = text.substr(examples);
    size_t count = 0;
    for (size_t at = commands.find("\n  livegs"); at != std::string::npos;
         at = commands.find("\n  livegs", at + 1))
      ++count;
    EXPECT_GE(count, 2u) << text;
    for (const char* untyped : {" TEXT", " UINT", " INT", " FLOAT", " in ["})
      EXPECT_EQ(text.find(untyped), std::string::npos) << untyped << "\n" << text;
  }
}

}  // namespace
}  // namespace livegs
