// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "system/support/program.h"

namespace livegs {

// The folder with the output of `livegs sample`, read-only. Written once for each build of `tool`, because it
// takes several seconds. Tests of other processes wait for it.
inline std::filesystem::path sample_files(const std::filesystem::path& tool) {
  namespace fs = std::filesystem;
  const fs::path root = tool.parent_path().parent_path() / "test_files";
  const fs::path files =
      root / ("sample_" + std::to_string(fs::last_write_time(tool).time_since_epoch().count()));
  fs::create_directories(root);
  const int lock = ::open((root / "lock").c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644);
  EXPECT_EQ(::flock(lock, LOCK_EX), 0);
  if (!fs::exists(files)) {
    for (const auto& old : fs::directory_iterator(root)) {
      if (old.is_directory()) fs::remove_all(old);
    }
    Program sample({tool, "sample", root / "new", "--quiet"});
    EXPECT_EQ(sample.wait(), 0) << sample.err();
    fs::rename(root / "new", files);
  }
  ::close(lock);
  return files;
}

}  // namespace livegs
