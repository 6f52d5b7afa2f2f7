// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <grpcpp/security/auth_metadata_processor.h>
#include <grpcpp/server_context.h>

#include <map>
#include <mutex>
#include <string>
#include <string_view>

#include "core/token_bucket.h"
#include "session/access/token_store.h"

namespace livegs {

// The scope that a call requires, by its path ("/livegs.v1.LiveGs/Join"). The health check requires none,
// since it reveals no more than an open port. An unlisted path requires admin, so that a call missing from
// the list is denied.
v1::Scope required_scope(std::string_view path);

// Rate limit per token: calls a second and burst size. The burst covers a client that fetches its assets
// after joining, one call each.
inline constexpr double kMaxCallsPerSecond = 200, kMaxCallsAtOnce = 2000;

// Authorises every call of every service before its handler runs. Used with TLS only; without TLS there is no
// authorisation. Non-blocking: one look-up in memory.
class CallAuthoriser final : public grpc::AuthMetadataProcessor {
 public:
  explicit CallAuthoriser(const TokenStore& tokens) : tokens_(tokens) {}

  bool IsBlocking() const override { return false; }
  // UNAUTHENTICATED: the token is missing, wrong, revoked or expired; the message says which.
  // PERMISSION_DENIED: the scope of the token is too narrow. RESOURCE_EXHAUSTED: the token exceeds its rate
  // limit.
  grpc::Status Process(const InputMetadata& metadata, grpc::AuthContext* context, OutputMetadata* consumed,
                       OutputMetadata* response) override;

 private:
  const TokenStore& tokens_;
  std::mutex mutex_;                          // guards calls_
  std::map<std::string, TokenBucket> calls_;  // by token id
};

// The token of an authorization header, "Bearer TOKEN"; empty for another form.
std::string_view bearer_token(std::string_view authorization);

// The authorization of a call, for its handler. `tokens` is null without TLS.
Result<Authorization> authorization_of(const grpc::CallbackServerContext& context, const TokenStore* tokens);

}  // namespace livegs
