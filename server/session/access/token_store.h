// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "session/access/authorization.h"

namespace livegs {

inline constexpr size_t kMaxTokens = 1000;
inline constexpr double kTokenDays = 90, kMaxTokenDays = 3650;

// Seconds since 1970.
using WallClock = std::function<int64_t()>;
WallClock system_wall_clock();

// The tokens of a server, in a file that holds their SHA-256 and not themselves. A fast hash will do: a token
// is 256 random bits, so whoever reads the file has nothing to guess from, as he would have with a password.
// Revoked and expired ones stay listed for a month, so that who shows one is told what it was. Any thread.
class TokenStore {
 public:
  // The file need not be there. InvalidData when it is none of ours.
  static Result<std::unique_ptr<TokenStore>> open(std::filesystem::path file,
                                                  WallClock clock = system_wall_clock());

  struct Made {
    v1::Token token;
    std::string secret;  // nobody can find it again
  };
  // InvalidArgument for a name, scope or number of days that will not do. On disk when it returns.
  Result<Made> add(const std::string& name, v1::Scope scope, double days);
  // A token that holds as long as this store lives and is in no file of its.
  std::string add_local_admin();
  Result<v1::Token> revoke(const std::string& id);
  std::vector<v1::Token> list() const;  // without their hashes

  // What a token allows. PermissionDenied, with what to do, when it is missing (empty), unknown, revoked or
  // expired. Every hash is compared, each in constant time.
  Result<Grant> check(std::string_view secret) const;
  // The same of a token that was good before.
  Result<void> check_still(const Grant& grant) const;

 private:
  TokenStore(std::filesystem::path file, WallClock clock)
      : file_(std::move(file)), clock_(std::move(clock)) {}
  Result<void> check_record(const v1::Token& token) const;
  Result<void> write() const;

  const std::filesystem::path file_;
  const WallClock clock_;
  mutable std::mutex mutex_;  // guards everything below
  v1::TokenFile tokens_;
  v1::Token local_admin_;  // without a hash: none
};

}  // namespace livegs
