// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace livegs {

struct ReplayOptions {
  std::string file;
  std::string folder;  // of the scene's assets; empty: where they were
  bool verify = false, json = false;
};

// livegs ctl replay: what a recording holds, or whether it comes out the same again. An exit code: 0 it does,
// 1 it does not.
int replay(const ReplayOptions& options);

}  // namespace livegs
