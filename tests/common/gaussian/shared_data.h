// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <filesystem>

namespace livegs {

inline std::filesystem::path shared_data() { return LIVEGS_SHARED_DATA_DIR; }

// Small inputs that users of splat tools had trouble with; its README says what is right.
inline std::filesystem::path shared_cases() { return shared_data().parent_path() / "cases"; }

}  // namespace livegs

#define LIVEGS_NEEDS_SHARED_DATA() \
  if (!std::filesystem::is_directory(livegs::shared_data())) GTEST_SKIP() << "shared data is not here"
