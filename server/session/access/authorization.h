// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "core/result.h"
#include "livegs/v1/admin.pb.h"

namespace livegs {

// What whoever calls may do, and by which token.
struct Grant {
  std::string token_id, token_name;  // empty in the clear, where everybody on this machine may do everything
  v1::Scope scope = v1::ADMIN;

  bool allows(v1::Scope needed) const { return scope >= needed; }
};

// "view", "interact", "author", "admin".
std::string scope_name(v1::Scope scope);
// InvalidArgument, with the names there are, for any other.
Result<v1::Scope> parse_scope(const std::string& name);

}  // namespace livegs
