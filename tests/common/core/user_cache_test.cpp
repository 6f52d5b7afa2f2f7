// SPDX-License-Identifier: Apache-2.0
#include "core/user_cache.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <optional>
#include <string>

namespace livegs {
namespace {

// Sets or unsets an environment variable and restores it.
class Variable {
 public:
  Variable(const char* name, const char* value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    value ? ::setenv(name, value, 1) : ::unsetenv(name);
  }
  ~Variable() { before_ ? ::setenv(name_, before_->c_str(), 1) : ::unsetenv(name_); }

 private:
  const char* name_;
  std::optional<std::string> before_;
};

TEST(UserCache, FollowsXdgThenHome) {
  const Variable home("HOME", "/home/someone");
  {
    const Variable cache("XDG_CACHE_HOME", "/caches");
    EXPECT_EQ(*user_cache_folder(), "/caches/livegs");
  }
  for (const char* value : {"relative/path", "", static_cast<const char*>(nullptr)}) {
    const Variable cache("XDG_CACHE_HOME", value);
    EXPECT_EQ(*user_cache_folder(), "/home/someone/.cache/livegs");
  }
}

TEST(UserCache, IsMissingWithoutAHome) {
  const Variable home("HOME", nullptr), cache("XDG_CACHE_HOME", nullptr);
  const auto folder = user_cache_folder();
  ASSERT_FALSE(folder);
  EXPECT_EQ(folder.error().code, ErrorCode::NotFound);
}

}  // namespace
}  // namespace livegs
