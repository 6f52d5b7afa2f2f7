// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>

#include "core/result.h"
#include "livegs/v1/admin.pb.h"

namespace livegs {

// The rights of a caller and the token that grants them.
struct Authorization {
  std::string token_id, token_name;  // empty without TLS, where every local caller is an admin
  v1::Scope scope = v1::ADMIN;
  int64_t fleet_expiry_unix_s = 0;  // of a token of the fleet; 0: another token

  bool allows(v1::Scope needed) const { return scope >= needed; }
};

// "view", "interact", "author", "admin".
std::string scope_name(v1::Scope scope);
// InvalidArgument for any other name; the message lists the valid names.
Result<v1::Scope> parse_scope(const std::string& name);

}  // namespace livegs
