// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/rpc/admin_service.h"

#include <algorithm>
#include <cctype>

#include "core/clock.h"
#include "core/log.h"
#include "session/rpc/grpc_status.h"
#include "session/support/version.h"
#include "trust/fingerprint.h"
#include "wire/frame_codec.h"

namespace livegs {
namespace {

constexpr size_t kMaxReason = 200;

grpc::ServerUnaryReactor* finish(grpc::CallbackServerContext* context, grpc::Status status) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(std::move(status));
  return reactor;
}

bool sayable(const std::string& reason) {
  return reason.size() <= kMaxReason &&
         std::all_of(reason.begin(), reason.end(), [](unsigned char c) { return std::isprint(c) != 0; });
}

const grpc::Status kNotSayable(grpc::StatusCode::INVALID_ARGUMENT,
                               "reason: is longer than 200 characters or not printable; shorten it");
const grpc::Status kNoTokens(grpc::StatusCode::FAILED_PRECONDITION,
                             "tokens: are not used without TLS; start the server with --tls on");

const char* state_name(ClientSession::State state) {
  switch (state) {
    case ClientSession::State::Joined:
      return "joined";
    case ClientSession::State::Streaming:
      return "streaming";
    case ClientSession::State::Parked:
      break;
  }
  return "parked";
}

}  // namespace

AdminService::AdminService(SessionTable& table, ServerSecurity* security, SessionRecorder& recorder)
    : table_(table), security_(security), recorder_(recorder), started_ns_(now_ns()) {}

void AdminService::set_drain(Drainer drain) {
  std::lock_guard lock(mutex_);
  drain_ = std::move(drain);
}

void AdminService::set_linker(Linker linker) {
  std::lock_guard lock(mutex_);
  linker_ = std::move(linker);
}

grpc::ServerUnaryReactor* AdminService::AddBrowserLink(grpc::CallbackServerContext* context,
                                                       const v1::AddBrowserLinkRequest*,
                                                       v1::BrowserLink* reply) {
  std::lock_guard lock(mutex_);
  if (linker_) *reply = linker_();
  return finish(context, grpc::Status::OK);
}

grpc::ServerUnaryReactor* AdminService::GetStatus(grpc::CallbackServerContext* context,
                                                  const v1::GetStatusRequest*, v1::ServerStatus* reply) {
  const SessionTable::Status status = table_.status();
  const int64_t now = now_ns();
  reply->set_version(kVersion);
  reply->set_protocol_version(kProtocolVersion);
  reply->set_scene(status.scene);
  reply->set_rate_hz(status.rate_hz);
  reply->set_tick(status.tick);
  reply->set_objects(static_cast<uint32_t>(status.objects));
  reply->set_serving(status.open);
  reply->set_secure(security_ != nullptr);
  if (security_) {
    reply->set_fingerprint(security_->fingerprint());
    reply->set_pairing_code(pairing_code(security_->fingerprint()));
  }
  reply->set_up_s(seconds_from_ns(now - started_ns_));
  reply->set_sessions(table_.totals().sessions);
  if (v1::RecordingStatus recording = recorder_.status(); !recording.path().empty())
    *reply->mutable_recording() = std::move(recording);
  for (const auto& session : table_.sessions_now()) {
    v1::ClientStatus& client = *reply->add_clients();
    client.set_session(session->id.substr(0, 8));
    client.set_name(session->who.name);
    client.set_peer(session->who.peer);
    client.set_token_id(session->who.authorization.token_id);
    client.set_token_name(session->who.authorization.token_name);
    client.set_scope(session->who.authorization.scope);
    client.set_state(state_name(session->state()));
    client.set_joined_s(seconds_from_ns(now - session->joined_ns));
    client.set_silent_s(seconds_from_ns(now - session->last_message_ns));
    client.set_frames_sent(session->frames_sent());
    client.set_frames_replaced(session->frames_replaced());
    client.set_bytes_sent(session->bytes_sent);
    client.set_acknowledged_ms(session->times().round_trip_ms.percentile(0.5));
  }
  return finish(context, grpc::Status::OK);
}

grpc::ServerUnaryReactor* AdminService::KickClient(grpc::CallbackServerContext* context,
                                                   const v1::KickClientRequest* request,
                                                   v1::KickClientReply* reply) {
  if (!sayable(request->reason())) return finish(context, kNotSayable);
  const Error why{ErrorCode::PermissionDenied,
                  "session: was ended by the server's operator" +
                      (request->reason().empty() ? "" : ": " + request->reason())};
  const auto ended = table_.end_session(request->session(), why);
  if (!ended) return finish(context, to_status(ended.error()));
  reply->set_session(ended->substr(0, 8));
  return finish(context, grpc::Status::OK);
}

grpc::ServerUnaryReactor* AdminService::AddToken(grpc::CallbackServerContext* context,
                                                 const v1::AddTokenRequest* request,
                                                 v1::AddTokenReply* reply) {
  if (!security_) return finish(context, kNoTokens);
  auto made = security_->tokens().add(request->name(), request->scope(), request->days());
  if (!made) return finish(context, to_status(made.error()));
  log_info("token %s: created for \"%s\", scope %s", made->token.id().c_str(), made->token.name().c_str(),
           scope_name(made->token.scope()).c_str());
  *reply->mutable_token() = std::move(made->token);
  reply->set_secret(std::move(made->secret));
  return finish(context, grpc::Status::OK);
}

grpc::ServerUnaryReactor* AdminService::ListTokens(grpc::CallbackServerContext* context,
                                                   const v1::ListTokensRequest*, v1::TokenList* reply) {
  if (!security_) return finish(context, kNoTokens);
  for (v1::Token& token : security_->tokens().list()) *reply->add_tokens() = std::move(token);
  return finish(context, grpc::Status::OK);
}

grpc::ServerUnaryReactor* AdminService::RevokeToken(grpc::CallbackServerContext* context,
                                                    const v1::RevokeTokenRequest* request, v1::Token* reply) {
  if (!security_) return finish(context, kNoTokens);
  auto revoked = security_->tokens().revoke(request->id());
  table_.end_unauthorised();  // also if the file could not be written
  if (!revoked) return finish(context, to_status(revoked.error()));
  log_info("token %s: revoked", revoked->id().c_str());
  *reply = std::move(*revoked);
  return finish(context, grpc::Status::OK);
}

grpc::ServerUnaryReactor* AdminService::Drain(grpc::CallbackServerContext* context,
                                              const v1::DrainRequest* request, v1::DrainReply*) {
  if (!sayable(request->reason())) return finish(context, kNotSayable);
  Drainer drain;
  {
    std::lock_guard lock(mutex_);
    drain = drain_;
  }
  if (!drain)
    return finish(context,
                  {grpc::StatusCode::UNAVAILABLE, "server: the scene is still loading; try again later"});
  drain(request->reason().empty() ? "requested by the operator" : request->reason());
  return finish(context, grpc::Status::OK);
}

grpc::ServerUnaryReactor* AdminService::StartRecording(grpc::CallbackServerContext* context,
                                                       const v1::StartRecordingRequest* request,
                                                       v1::RecordingStatus* reply) {
  auto started = recorder_.start(request->path(), {request->inputs_only(), request->assets()});
  if (!started) return finish(context, to_status(started.error()));
  log_info("recording %s: started", request->path().c_str());
  *reply = recorder_.status();
  return finish(context, grpc::Status::OK);
}

grpc::ServerUnaryReactor* AdminService::StopRecording(grpc::CallbackServerContext* context,
                                                      const v1::StopRecordingRequest*,
                                                      v1::RecordingStatus* reply) {
  auto stopped = recorder_.stop();
  if (!stopped) return finish(context, to_status(stopped.error()));
  *reply = std::move(*stopped);
  return finish(context, grpc::Status::OK);
}

}  // namespace livegs
