// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <unistd.h>

#include <filesystem>
#include <memory>
#include <string>

#include "system/support/program.h"

namespace livegs {

// A separate X display for a test (package xvfb, listed in deploy/packages.txt). `display` is empty if none
// started; `program` then has the error output. A lock file reserves the display number from before the start
// until after the end. Without it (-displayfd without a number), a server that ends can remove the socket of
// one that starts.
class Screen {
 public:
  static bool there_is_one() { return std::filesystem::exists("/usr/bin/Xvfb"); }

  Screen() {
    for (int number = kFirstDisplay; number < kFirstDisplay + kDisplayCount && display.empty(); ++number) {
      const auto file = std::filesystem::temp_directory_path() / ("livegs_display_" + std::to_string(number));
      lock_ = ::open(file.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0600);
      if (lock_ >= 0 && ::flock(lock_, LOCK_EX | LOCK_NB) == 0) start(number);
      if (display.empty()) release();
    }
  }
  ~Screen() {
    if (program && program->process() > 0) {
      program->send(SIGTERM);
      program->wait();
    }
    release();
  }
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  std::unique_ptr<Program> program;
  std::string display;

 private:
  static constexpr int kFirstDisplay = 90, kDisplayCount = 64;

  // If another program uses this number, the server exits with a message.
  void start(int number) {
    const std::string name = ":" + std::to_string(number);
    // wait_for checks for windows as the first client and disconnects. Without -noreset, the server would
    // then reset and refuse clients meanwhile.
    program = std::make_unique<Program>(std::vector<std::string>{"/usr/bin/Xvfb", name, "-noreset",
                                                                 "-displayfd", "1", "-screen", "0",
                                                                 "1960x1020x24", "-nolisten", "tcp"});
    if (!program->first_line().empty()) display = name;
  }
  void release() {
    if (lock_ >= 0) ::close(lock_);
    lock_ = -1;
  }

  int lock_ = -1;
};

}  // namespace livegs
