// SPDX-License-Identifier: Apache-2.0
// The desktop window on a display that nobody looks at (Xvfb): screenshots before, during and after a pull.
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <filesystem>

#include "splat/image.h"
#include "system/program.h"

namespace livegs {
namespace {

constexpr const char* kScene = R"({
  "environment": { "colliders": [ { "plane": {} } ] },
  "objects": [
    { "name": "box", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } }, "pose": { "position_m": [-0.3, 0.1, 0] },
      "physics": { "behavior": "RIGID", "mass_kg": 1 } },
    { "name": "cube", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } }, "pose": { "position_m": [0.3, 0.1, 0] },
      "physics": { "behavior": "ELASTIC", "density_kg_m3": 300, "youngs_modulus_pa": 2e4 } } ] })";

class Window : public ::testing::Test {
 protected:
  ScratchFolder folder_;

  std::vector<std::string> client(const std::string& display, const std::string& address) {
    return {"/usr/bin/env", "DISPLAY=" + display,
            LIVEGS_CLIENT,  address,
            "--display",    "window",
            "--size",       "800x500",
            "--cache",      folder_ / "cache",
            "--threads",    "2"};
  }
};

// Pixels that differ by more than a twentieth, left of the panels' lower half and all over the right.
size_t changed(const Image& a, const Image& b) {
  size_t count = 0;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      double most = 0;
      for (int c = 0; c < 3; ++c) most = std::max<double>(most, std::abs(a.at(x, y)[c] - b.at(x, y)[c]));
      count += most > 0.05 && (y > a.height / 2 || x > a.width / 2);
    }
  }
  return count;
}

TEST_F(Window, ShowsTheSceneAndAPull) {
  if (!std::filesystem::exists("/usr/bin/Xvfb")) GTEST_SKIP() << "no Xvfb; install xvfb";
  Program screen({"/usr/bin/Xvfb", "-displayfd", "1", "-screen", "0", "1000x700x24", "-nolisten", "tcp"});
  const std::string number = screen.first_line();
  ASSERT_NE(number, "") << screen.err();
  Program server({LIVEGS_SERVER, folder_.write("boxes.scene.json", kScene), "--listen", "127.0.0.1:0",
                  "--print-port", "--threads", "1"});
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  auto words = client(":" + number, "127.0.0.1:" + port);
  const std::string shots = folder_ / "shots";
  for (const char* word : {"--seconds", "5", "--poke", "box", "--output"}) words.push_back(word);
  words.push_back(shots);
  Program window(words);
  EXPECT_EQ(window.wait(), 0) << window.err();

  std::vector<Image> images;
  for (int i = 0; i < 20; ++i) {
    char name[32];
    std::snprintf(name, sizeof name, "window_%03d.png", i);
    const auto image = read_png(std::filesystem::path(shots) / name);
    if (!image) break;
    images.push_back(*image);
  }
  ASSERT_GE(images.size(), 4u) << window.err();
  const Image& before = images.front();
  ASSERT_EQ(before.width, 800);
  ASSERT_EQ(before.height, 500);
  float darkest = 1, brightest = 0;
  for (size_t i = 0; i < before.pixels.size(); i += 4) {
    darkest = std::min(darkest, before.pixels[i]);
    brightest = std::max(brightest, before.pixels[i]);
  }
  EXPECT_GT(brightest - darkest, 0.5f);
  // The box is drawn up and a force arrow stands at it: some hundred pixels at the least.
  size_t most = 0;
  for (const Image& image : images) most = std::max(most, changed(before, image));
  EXPECT_GT(most, 400u);

  server.send(SIGTERM);
  EXPECT_EQ(server.wait(), 0) << server.err();
}

// The last picture stays, with a notice, and the window ends when its time is up.
TEST_F(Window, OutlivesItsServer) {
  if (!std::filesystem::exists("/usr/bin/Xvfb")) GTEST_SKIP() << "no Xvfb; install xvfb";
  Program screen({"/usr/bin/Xvfb", "-displayfd", "1", "-screen", "0", "1000x700x24", "-nolisten", "tcp"});
  const std::string number = screen.first_line();
  ASSERT_NE(number, "") << screen.err();
  Program server({LIVEGS_SERVER, folder_.write("boxes.scene.json", kScene), "--listen", "127.0.0.1:0",
                  "--print-port", "--threads", "1"});
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  auto words = client(":" + number, "127.0.0.1:" + port);
  for (const char* word : {"--seconds", "3", "--renderer", "cpu"}) words.push_back(word);
  Program window(words);
  ASSERT_TRUE(server.says("streaming to")) << server.err();
  server.send(SIGKILL);
  EXPECT_TRUE(window.says("the server has gone")) << window.err();
  EXPECT_EQ(window.wait(), 0) << window.err();
}

TEST_F(Window, WithoutADisplayItIsOneLineAndCodeOne) {
  Program window(client("", "127.0.0.1:1"));
  EXPECT_EQ(window.wait(), 1);
  const std::string err = window.err();
  EXPECT_EQ(std::count(err.begin(), err.end(), '\n'), 1) << err;
  EXPECT_NE(err.find("--display offscreen"), std::string::npos) << err;
}

}  // namespace
}  // namespace livegs
