// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <filesystem>

namespace livegs {

inline std::filesystem::path shared_data() { return LIVEGS_SHARED_DATA_DIR; }

}  // namespace livegs

#define LIVEGS_NEEDS_SHARED_DATA() \
  if (!std::filesystem::is_directory(livegs::shared_data())) GTEST_SKIP() << "shared data is not here"
