// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "stream/session/scene_control.h"
#include "system/support/program.h"
#include "system/support/sample_files.h"

namespace livegs {

// The server of a scene that authors edit: FOLDER/made/room.scene.json, with the assets of the sample scene
// in FOLDER/sample.
class AuthorServer {
 public:
  // Makes the folders.
  explicit AuthorServer(std::filesystem::path folder) : folder_(std::move(folder)) {
    std::filesystem::create_directory_symlink(sample_files(LIVEGS_TOOL), folder_ / "sample");
    std::filesystem::create_directories(folder_ / "made");
  }
  ~AuthorServer() {
    if (program_) program_->send(SIGTERM);
  }

  // `fresh`: the scene file need not exist.
  void start(bool fresh) {
    std::vector<std::string> words = {LIVEGS_SERVER,        file(),         "--listen",
                                      "127.0.0.1:" + port_, "--print-port", "--offline"};
    if (fresh) words.push_back("--new");
    program_ = std::make_unique<Program>(words);
    port_ = program_->first_line();
    ASSERT_NE(port_, "") << program_->err();
    control_ = std::make_unique<SceneControl>(address());
  }
  // Saves nothing.
  void stop() {
    program_->send(SIGTERM);
    EXPECT_EQ(program_->wait(), 0);
    port_ = "0";
  }
  // A later start() listens at the same port.
  void kill() {
    program_->send(SIGKILL);
    program_->wait();
  }

  std::filesystem::path file() const { return folder_ / "made/room.scene.json"; }
  std::string port() const { return port_; }
  std::string address() const { return "127.0.0.1:" + port_; }
  SceneControl& control() { return *control_; }
  // An empty scene if the server does not answer.
  v1::Scene scene() {
    const auto document = control_->scene();
    return document ? document->scene() : v1::Scene();
  }

 private:
  std::filesystem::path folder_;
  std::string port_ = "0";
  std::unique_ptr<Program> program_;
  std::unique_ptr<SceneControl> control_;
};

}  // namespace livegs
