// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "system/program.h"

namespace livegs {

// A display of its own for a test's windows (package xvfb, which deploy/packages.txt has). `display` is empty where it
// did not start.
struct Screen {
  static bool there_is_one() { return std::filesystem::exists("/usr/bin/Xvfb"); }

  std::unique_ptr<Program> program = std::make_unique<Program>(std::vector<std::string>{
      "/usr/bin/Xvfb", "-displayfd", "1", "-screen", "0", "1300x820x24", "-nolisten", "tcp"});
  std::string display = [this] {
    const std::string number = program->first_line();
    return number.empty() ? number : ":" + number;
  }();
};

}  // namespace livegs
