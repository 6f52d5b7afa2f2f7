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

// A display of its own for a test's windows (package xvfb, which deploy/packages.txt has). `display` is empty
// where none started, and `program` says why. Its number is this test's alone from before it starts until
// after it has ended, by a lock on a file: of servers that choose for themselves (-displayfd without a
// number) one that ends takes away the socket of another that begins.
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

  // Somebody else's display may have this number; then the server ends and says so.
  void start(int number) {
    const std::string name = ":" + std::to_string(number);
    // Who looks whether a window is there yet is its first client and leaves again, which would make it begin
    // anew, and refuse who comes meanwhile.
    program = std::make_unique<Program>(std::vector<std::string>{"/usr/bin/Xvfb", name, "-noreset",
                                                                 "-displayfd", "1", "-screen", "0",
                                                                 "1300x820x24", "-nolisten", "tcp"});
    if (!program->first_line().empty()) display = name;
  }
  void release() {
    if (lock_ >= 0) ::close(lock_);
    lock_ = -1;
  }

  int lock_ = -1;
};

}  // namespace livegs
