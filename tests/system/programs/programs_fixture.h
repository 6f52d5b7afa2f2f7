// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "system/support/program.h"

namespace livegs {

// The scene: a box and a soft cube on a floor. Also the command lines of the programs.
inline constexpr const char* kBoxesScene = R"({
  "environment": { "colliders": [ { "plane": {} } ] },
  "objects": [
    { "name": "box", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } }, "pose": { "position_m": [-0.3, 0.1, 0] },
      "physics": { "behavior": "RIGID", "mass_kg": 1 } },
    { "name": "cube", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } }, "pose": { "position_m": [0.3, 0.1, 0] },
      "physics": { "behavior": "ELASTIC", "density_kg_m3": 300, "youngs_modulus_pa": 2e4 } } ] })";

class Programs : public ::testing::Test {
 protected:
  std::vector<std::string> server_words(std::vector<std::string> more = {}) {
    std::vector<std::string> words = {LIVEGS_SERVER,
                                      folder_.write("boxes.scene.json", kBoxesScene),
                                      "--listen",
                                      "127.0.0.1:0",
                                      "--print-port",
                                      "--threads",
                                      "1"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  std::vector<std::string> client_words(const std::string& port, std::vector<std::string> more = {},
                                        const std::string& output = "view") {
    std::vector<std::string> words = {LIVEGS_CLIENT, "127.0.0.1:" + port, "--display", "offscreen",
                                      "--output",    folder_ / output,    "--cache",   folder_ / "cache",
                                      "--size",      "160x120",           "--threads", "1"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  // Ticks of the frames that the client with this output folder received.
  std::vector<uint64_t> ticks_of(const std::string& output) const {
    std::ifstream file(folder_ / output / "frames.csv");
    std::string line;
    std::getline(file, line);  // the header
    std::vector<uint64_t> ticks;
    while (std::getline(file, line)) ticks.push_back(std::stoull(line));
    return ticks;
  }
  // Expects one line on standard error that contains `named`, and no standard output.
  static void expect_one_line(const Program& program, const std::string& named) {
    const std::string err = program.err();
    EXPECT_EQ(std::count(err.begin(), err.end(), '\n'), 1) << err;
    EXPECT_NE(err.find(named), std::string::npos) << err;
    EXPECT_EQ(program.out(), "");
  }
  ScratchFolder folder_;
};

}  // namespace livegs
