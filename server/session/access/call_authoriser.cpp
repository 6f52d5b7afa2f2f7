// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/access/call_authoriser.h"

#include "core/clock.h"

namespace livegs {
namespace {

constexpr std::string_view kBearer = "Bearer ";
// Tokens with a rate limit of their own before idle ones are dropped. A server's own list has fewer; tokens
// of a fleet are not limited in number.
constexpr size_t kMaxRatedTokens = 4 * kMaxTokens;

// The bearer token of a call; empty if there is not exactly one.
std::string_view token_in(const grpc::AuthMetadataProcessor::InputMetadata& metadata) {
  const auto found = metadata.find("authorization");
  if (found == metadata.end() || metadata.count("authorization") != 1) return {};
  return bearer_token({found->second.data(), found->second.size()});
}

}  // namespace

std::string_view bearer_token(std::string_view authorization) {
  return authorization.starts_with(kBearer) ? authorization.substr(kBearer.size()) : std::string_view();
}

v1::Scope required_scope(std::string_view path) {
  static const std::map<std::string_view, v1::Scope> kRequiredScopes = {
      {"/grpc.health.v1.Health/Check", v1::SCOPE_UNSPECIFIED},
      {"/livegs.v1.LiveGs/GetServerInfo", v1::VIEW},
      {"/livegs.v1.LiveGs/Join", v1::VIEW},
      {"/livegs.v1.LiveGs/FetchAsset", v1::VIEW},
      {"/livegs.v1.Spectators/DescribeScene", v1::VIEW},
      // Hand input additionally requires INTERACT; SessionTable::on_input checks it (session_table.cpp).
      {"/livegs.v1.LiveGs/Stream", v1::VIEW},
      {"/livegs.v1.LiveGs/AnalyzeObject", v1::VIEW},
      {"/livegs.v1.LiveGs/ApplyForce", v1::INTERACT},
      {"/livegs.v1.LiveGs/AnalyzeScene", v1::AUTHOR},
      {"/livegs.v1.LiveGs/SetPhysics", v1::AUTHOR},
      {"/livegs.v1.LiveGs/AcceptProposal", v1::AUTHOR},
      {"/livegs.v1.LiveGs/UndoPhysics", v1::AUTHOR},
      {"/livegs.v1.LiveGs/ControlRun", v1::AUTHOR},
      {"/livegs.v1.LiveGs/EditScene", v1::AUTHOR},
      {"/livegs.v1.LiveGs/UndoEdit", v1::AUTHOR},
      {"/livegs.v1.LiveGs/CarryObject", v1::AUTHOR},
      {"/livegs.v1.LiveGs/GetScene", v1::AUTHOR},
      {"/livegs.v1.LiveGs/SaveScene", v1::AUTHOR},
      {"/livegs.v1.LiveGs/ListAssets", v1::AUTHOR},
      {"/livegs.v1.LiveGs/UploadAsset", v1::AUTHOR},
      {"/livegs.v1.LiveGs/GetRoomParts", v1::AUTHOR},
      {"/livegs.v1.LiveGs/TakePart", v1::AUTHOR},
      {"/livegs.v1.LiveGs/PutBack", v1::AUTHOR},
  };
  const auto found = kRequiredScopes.find(path);
  return found == kRequiredScopes.end() ? v1::ADMIN : found->second;
}

grpc::Status CallAuthoriser::Process(const InputMetadata& metadata, grpc::AuthContext*, OutputMetadata*,
                                     OutputMetadata*) {
  const auto path = metadata.find(":path");
  const v1::Scope needed =
      path == metadata.end() ? v1::ADMIN : required_scope({path->second.data(), path->second.size()});
  if (needed == v1::SCOPE_UNSPECIFIED) return grpc::Status::OK;
  const auto authorization = tokens_.check(token_in(metadata));
  if (!authorization) return {grpc::StatusCode::UNAUTHENTICATED, authorization.error().message};
  if (!authorization->allows(needed)) {
    return {grpc::StatusCode::PERMISSION_DENIED, "token \"" + authorization->token_name + "\": has scope " +
                                                     scope_name(authorization->scope) +
                                                     "; use one with scope " + scope_name(needed)};
  }
  std::lock_guard lock(mutex_);
  // Entries of ended tokens are kept while they are few. Idle ones have a full bucket and lose nothing.
  if (calls_.size() >= kMaxRatedTokens)
    std::erase_if(calls_, [now = now_ns()](const auto& one) {
      TokenBucket bucket = one.second;
      return bucket.refill(now) >= kMaxCallsAtOnce;
    });
  TokenBucket& calls =
      calls_.try_emplace(authorization->token_id, kMaxCallsPerSecond, kMaxCallsAtOnce).first->second;
  if (!calls.try_take(now_ns())) {
    return {grpc::StatusCode::RESOURCE_EXHAUSTED,
            "calls: more than 200 a second with this token; send fewer"};
  }
  return grpc::Status::OK;
}

Result<Authorization> authorization_of(const grpc::CallbackServerContext& context, const TokenStore* tokens) {
  if (tokens == nullptr) return Authorization{};
  return tokens->check(token_in(context.client_metadata()));
}

}  // namespace livegs
