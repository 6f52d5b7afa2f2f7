// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace livegs {

struct ReplayRequest {
  std::string file;
  std::string folder;  // folder of the scene's assets; empty: their recorded location
  bool verify = false, json = false;
};

// Implements livegs ctl replay: prints a summary of a recording, or verifies it by simulation. Returns the
// exit code: 0 success or equal, 1 otherwise.
int replay(const ReplayRequest& options);

}  // namespace livegs
