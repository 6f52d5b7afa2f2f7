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

// What a call needs, by its path ("/livegs.v1.LiveGs/Join"). Nothing at all for the health check, which tells
// no more than an open port; admin for a path that is not listed, so that a call that is forgotten here is
// shut and not open.
v1::Scope required_scope(std::string_view path);

// Of one token: a client that joins fetches an asset a call.
inline constexpr double kMaxCallsPerSecond = 200, kMaxCallsAtOnce = 2000;

// The one place where calls are let in: gRPC asks it of each, of every service, before its handler sees
// anything. With TLS only; in the clear there is none. Non-blocking: a look-up in memory.
class CallAuthoriser final : public grpc::AuthMetadataProcessor {
 public:
  explicit CallAuthoriser(const TokenStore& tokens) : tokens_(tokens) {}

  bool IsBlocking() const override { return false; }
  // UNAUTHENTICATED: a token is missing, wrong, revoked or expired, and the message says which.
  // PERMISSION_DENIED: it does not reach so far. RESOURCE_EXHAUSTED: it calls too often.
  grpc::Status Process(const InputMetadata& metadata, grpc::AuthContext* context, OutputMetadata* consumed,
                       OutputMetadata* response) override;

 private:
  const TokenStore& tokens_;
  std::mutex mutex_;                          // guards calls_
  std::map<std::string, TokenBucket> calls_;  // by token
};

// Whose call this is, for a handler. `tokens` null: in the clear.
Result<Grant> grant_of(const grpc::CallbackServerContext& context, const TokenStore* tokens);

}  // namespace livegs
