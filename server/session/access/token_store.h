// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "core/token_bucket.h"
#include "session/access/authorization.h"

namespace livegs {

inline constexpr size_t kMaxTokens = 1000;
inline constexpr double kTokenDays = 90, kMaxTokenDays = 3650;

// Returns seconds since 1970.
using WallClock = std::function<int64_t()>;
WallClock system_wall_clock();

// The tokens of a server. The file stores their SHA-256 hashes, not the tokens. A fast hash is sufficient: a
// token has 256 random bits, so it cannot be guessed from its hash. Revoked and expired tokens stay listed
// for a month, so that a refused caller gets the reason. Any thread.
class TokenStore {
 public:
  // The file may be missing. InvalidData if it is not a token file.
  static Result<std::unique_ptr<TokenStore>> open(std::filesystem::path file,
                                                  WallClock clock = system_wall_clock());

  struct Made {
    v1::Token token;
    std::string secret;  // not stored, cannot be recovered
  };
  // Creates a token and writes the file before it returns. InvalidArgument for an invalid name, scope or
  // number of days.
  Result<Made> add(const std::string& name, v1::Scope scope, double days);
  // Creates an admin token that is valid for the lifetime of this store and is not written to the file.
  std::string add_local_admin();
  Result<v1::Token> revoke(const std::string& id);
  std::vector<v1::Token> list() const;  // without hashes

  // Also accepts tokens that are signed with this key for this server (fleet_token.h). They are not listed
  // and cannot be revoked one by one; a new key ends all of them.
  void accept_fleet(std::string key, std::string server);
  // A token of the fleet for another server, with the name, scope and expiry of this authorization. NotFound
  // if that is not from a token of the fleet.
  Result<std::string> fleet_token_for(const std::string& server, const Authorization& authorization) const;

  // The authorization of a token. PermissionDenied, with a remedy, if it is missing (empty), unknown, revoked
  // or expired. All hashes are compared, each in constant time. A refused token of the fleet is unknown to
  // the caller; the cause is logged, at most one line a second.
  Result<Authorization> check(std::string_view secret) const;
  // The same check for a token that was valid before.
  Result<void> check_still(const Authorization& authorization) const;

 private:
  TokenStore(std::filesystem::path file, WallClock clock)
      : file_(std::move(file)), clock_(std::move(clock)) {}
  Result<Authorization> check_fleet(std::string_view secret) const;
  Result<void> check_record(const v1::Token& token) const;
  Result<void> write() const;

  const std::filesystem::path file_;
  const WallClock clock_;
  mutable std::mutex mutex_;  // guards everything below
  v1::TokenFile tokens_;
  v1::Token local_admin_;  // no hash: not created
  std::string fleet_key_, fleet_server_;
  mutable TokenBucket refusals_logged_{1, 10};  // lines a second and at once: a flood must not fill the log
};

}  // namespace livegs
