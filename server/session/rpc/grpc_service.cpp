// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/rpc/grpc_service.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "core/clock.h"
#include "core/log.h"
#include "session/access/call_authoriser.h"
#include "session/rpc/analysis_call.h"
#include "session/rpc/asset_call.h"
#include "session/rpc/grpc_status.h"
#include "session/rpc/stream_call.h"
#include "session/simulation/hand_controls.h"
#include "session/support/version.h"
#include "wire/call_metadata.h"
#include "wire/driver_grid.h"
#include "wire/frame_codec.h"
#include "wire/kernel_codec.h"

namespace livegs {
namespace {

constexpr size_t kMaxClientName = 64;
constexpr double kBytesPerMbit = 1e6 / 8;
// Minimum bandwidth cap. With less, the first frame would take seconds.
constexpr double kMinMbit_s = 0.1;
// Minimum frame rate. Below it the client's playout restarts at every frame.
constexpr double kMinRate_hz = 5;

// Client names are logged: replaces all but printable ASCII.
std::string printable(const std::string& name) {
  std::string text = name.substr(0, kMaxClientName);
  for (char& c : text) {
    if (std::isprint(static_cast<unsigned char>(c)) == 0) c = '?';
  }
  return text;
}

Error no_analysis() {
  return {ErrorCode::Unavailable,
          "physics: cannot be changed: the scene is still loading or this server allows no edits; try again "
          "later"};
}

grpc::Status answer(Result<v1::PhysicsReply> result, v1::PhysicsReply& reply) {
  if (!result) return to_status(result.error());
  reply = std::move(*result);
  return grpc::Status::OK;
}

}  // namespace

grpc::ServerUnaryReactor* GrpcService::GetServerInfo(grpc::CallbackServerContext* context,
                                                     const v1::GetServerInfoRequest*, v1::ServerInfo* reply) {
  const SessionTable::Status status = table_.status();
  reply->set_version(kVersion);
  reply->set_protocol_version(kProtocolVersion);
  reply->set_scene(status.scene);
  reply->set_rate_hz(status.rate_hz);
  reply->set_tick(status.tick);
  reply->set_object_count(static_cast<uint32_t>(status.objects));
  reply->set_client_count(static_cast<uint32_t>(status.clients));
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(grpc::Status::OK);
  return reactor;
}

grpc::ServerUnaryReactor* GrpcService::Join(grpc::CallbackServerContext* context,
                                            const v1::JoinRequest* request, v1::JoinReply* reply) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(join(*context, *request, *reply));
  return reactor;
}

namespace {

// Checks that frames of the scene can be sent in this encoding.
Result<void> check_encoding(v1::JoinRequest::Encoding encoding, const SessionTable::Described& scene) {
  if (!v1::JoinRequest::Encoding_IsValid(encoding)) {
    return invalid_argument("encoding: " + std::to_string(encoding) +
                            " is not a livegs.v1.JoinRequest.Encoding; use 0 to 3 (DRIVERS, DRIVERS_RAW, "
                            "KERNELS, KERNELS_EXACT)");
  }
  if (!is_kernel_encoding(encoding)) return {};
  size_t bytes = kKernelFrameHeaderBytes, kernels = 0;
  for (const SessionTable::Object& object : scene.objects) {
    kernels += object->kernel_count();
    bytes +=
        kernel_bytes(object->kernel_count(), encoding == v1::JoinRequest::KERNELS ? KernelEncoding::Quantised
                                                                                  : KernelEncoding::Exact);
  }
  if (bytes <= kMaxFrameBytes) return {};
  return invalid_argument("encoding: the scene's " + std::to_string(kernels) + " kernels take " +
                          std::to_string(bytes >> 20) + " MiB, more than the limit of a frame, " +
                          std::to_string(kMaxFrameBytes >> 20) + " MiB; use DRIVERS" +
                          (encoding == v1::JoinRequest::KERNELS ? "" : " or KERNELS, which are smaller"));
}

}  // namespace

grpc::Status GrpcService::join(const grpc::CallbackServerContext& context, const v1::JoinRequest& request,
                               v1::JoinReply& reply) {
  if (request.protocol_version() != kProtocolVersion) {
    return {grpc::StatusCode::FAILED_PRECONDITION,
            "protocol: the client has version " + std::to_string(request.protocol_version()) +
                " and the server (livegs " + kVersion + ") version " + std::to_string(kProtocolVersion) +
                "; update the older one"};
  }
  const double wish_mbit_s = request.max_mbit_s();
  if (wish_mbit_s != 0 && !(wish_mbit_s >= kMinMbit_s)) {  // NaN too
    return {grpc::StatusCode::INVALID_ARGUMENT,
            "max_mbit_s: must be at least 0.1; use 0 for the limit of the server"};
  }
  const double wish_hz = request.rate_hz();
  if (wish_hz != 0 && !(wish_hz >= kMinRate_hz)) {
    return {grpc::StatusCode::INVALID_ARGUMENT, "rate_hz: must be at least 5; use 0 for a frame each tick"};
  }
  const uint32_t position_bits = request.position_bits() == 0 ? 16 : request.position_bits();
  if (!may_ask_for(position_bits)) {
    return {grpc::StatusCode::INVALID_ARGUMENT,
            "position_bits: " + std::to_string(position_bits) + " is not 16, 18 or 20; use 0 for 16"};
  }
  const auto scene = table_.described(request.resumed_session_id());
  if (!scene) return to_status(scene.error());
  if (auto checked = check_encoding(request.encoding(), *scene); !checked) return to_status(checked.error());
  auto authorization = authorization_of(context, tokens_);
  if (!authorization)
    return to_status(authorization.error());  // it was revoked or expired after authorisation
  const v1::Scope scope = authorization->scope;
  const bool may_start = authorization->allows(v1::AUTHOR);
  const std::string token = authorization->token_name;
  const std::string name = printable(request.client_name()), peer = context.peer();
  JoinTerms terms;
  terms.max_bytes_s = wish_mbit_s == 0 ? cap_bytes_s_ : std::min(cap_bytes_s_, wish_mbit_s * kBytesPerMbit);
  terms.position_bits = static_cast<int>(position_bits);
  terms.encoding = request.encoding();
  terms.every =
      static_cast<uint64_t>(std::max(1.0, wish_hz == 0 ? 1.0 : std::floor(scene->rate_hz / wish_hz + 1e-9)));
  terms.tick_ns = static_cast<int64_t>(1e9 / scene->rate_hz);
  auto joined = table_.join(request.resumed_session_id(), {std::move(*authorization), name, peer}, terms);
  if (!joined) return to_status(joined.error());
  if (request.starts_run() && may_start) starter_joined_ = true;
  reply.set_stream_rate_hz(scene->rate_hz / static_cast<double>(terms.every));
  reply.set_session_id(joined->session->id);
  reply.set_rate_hz(scene->rate_hz);
  reply.set_tick(table_.status().tick);
  reply.set_ball_speed_m_s(kBallSpeed_m_s);
  reply.set_server_instance(table_.instance());
  reply.set_encoding(request.encoding());
  reply.set_view_only(scope < v1::INTERACT);
  for (const SessionTable::Object& object : joined->objects) *reply.add_objects() = *object;
  if (!store_.url.empty()) {
    reply.set_asset_store(store_.url);
    for (const ClientStore::Asset& asset : store_.assets) {
      v1::StoredAsset& stored = *reply.add_stored_assets();
      stored.set_hash(asset.hash);
      stored.set_web_sha256(asset.web_sha256);
    }
  }
  log_info("session %.8s: \"%s\" joined %sfrom %s%s", joined->session->id.c_str(), name.c_str(),
           joined->session->id == request.resumed_session_id() ? "again " : "", peer.c_str(),
           token.empty() ? "" : (" with the token \"" + token + "\", " + scope_name(scope)).c_str());
  return grpc::Status::OK;
}

std::shared_ptr<ClientSession> GrpcService::session_of(const grpc::CallbackServerContext& context) const {
  const auto named = context.client_metadata().find(kSessionMetadata);
  if (named == context.client_metadata().end()) return nullptr;
  const auto authorization = authorization_of(context, tokens_);
  auto session = table_.find({named->second.data(), named->second.size()});
  const bool own = session && authorization && session->who.authorization.token_id == authorization->token_id;
  return own ? session : nullptr;
}

grpc::ServerWriteReactor<v1::AssetChunk>* GrpcService::FetchAsset(grpc::CallbackServerContext* context,
                                                                  const v1::FetchAssetRequest* request) {
  auto session = session_of(*context);
  auto budget = session ? session->budget : peer_budget(context->peer());
  return AssetCall::start(assets_, *request, std::move(budget), std::move(session));
}

grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* GrpcService::Stream(
    grpc::CallbackServerContext* context) {
  return StreamCall::start(table_, authorization_of(*context, tokens_), *context);
}

grpc::ServerUnaryReactor* GrpcService::AnalyzeObject(grpc::CallbackServerContext* context,
                                                     const v1::AnalyzeObjectRequest* request,
                                                     v1::AnalyzeObjectReply* reply) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(analyze(*request, *reply));
  return reactor;
}

grpc::ServerWriteReactor<v1::AnalysisProgress>* GrpcService::AnalyzeScene(
    grpc::CallbackServerContext*, const v1::AnalyzeSceneRequest* request) {
  return new AnalysisCall(analysis_, *request);
}

grpc::ServerUnaryReactor* GrpcService::SetPhysics(grpc::CallbackServerContext* context,
                                                  const v1::SetPhysicsRequest* request,
                                                  v1::PhysicsReply* reply) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  AnalysisControl* analysis = analysis_;
  const auto set = analysis ? analysis->set_physics(request->object(), request->physics(), request->name())
                            : Result<v1::PhysicsReply>(no_analysis());
  if (AuthorControl* edits = author(); set && edits) edits->note_physics(request->object());
  reactor->Finish(answer(set, *reply));
  return reactor;
}

grpc::ServerUnaryReactor* GrpcService::AcceptProposal(grpc::CallbackServerContext* context,
                                                      const v1::AcceptProposalRequest* request,
                                                      v1::PhysicsReply* reply) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  AnalysisControl* analysis = analysis_;
  reactor->Finish(answer(!analysis            ? Result<v1::PhysicsReply>(no_analysis())
                         : request->decline() ? analysis->decline_proposal(request->object())
                                              : analysis->accept_proposal(request->object()),
                         *reply));
  return reactor;
}

grpc::ServerUnaryReactor* GrpcService::UndoPhysics(grpc::CallbackServerContext* context,
                                                   const v1::UndoPhysicsRequest* request,
                                                   v1::PhysicsReply* reply) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  AnalysisControl* analysis = analysis_;
  reactor->Finish(answer(analysis ? analysis->undo_physics(request->object(), request->redo())
                                  : Result<v1::PhysicsReply>(no_analysis()),
                         *reply));
  return reactor;
}

grpc::ServerUnaryReactor* GrpcService::ControlRun(grpc::CallbackServerContext* context,
                                                  const v1::ControlRunRequest* request, v1::RunState* reply) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(control_run(*request, *reply));
  return reactor;
}

grpc::Status GrpcService::control_run(const v1::ControlRunRequest& request, v1::RunState& reply) const {
  RunControl* run = run_;
  if (!run)
    return {grpc::StatusCode::UNAVAILABLE,
            "run: cannot be controlled: the scene is still loading or this server allows no control; try "
            "again later"};
  const auto status = run->control(request);
  if (!status) return to_status(status.error());
  write_run(*status, reply);
  return grpc::Status::OK;
}

grpc::ServerUnaryReactor* GrpcService::ApplyForce(grpc::CallbackServerContext* context,
                                                  const v1::ApplyForceRequest* request,
                                                  v1::ApplyForceReply* reply) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(apply_force(*request, *reply));
  return reactor;
}

grpc::Status GrpcService::apply_force(const v1::ApplyForceRequest& request,
                                      v1::ApplyForceReply& reply) const {
  RunControl* run = run_;
  if (!run)
    return {grpc::StatusCode::UNAVAILABLE,
            "force: cannot be applied: the scene is still loading or this server accepts no forces; try "
            "again later"};
  if (!table_.object(request.force().object())) return unknown_object(request.force().object());
  reply.set_tick(table_.status().tick);
  if (auto applied = run->apply_force(request.force()); !applied) return to_status(applied.error());
  return grpc::Status::OK;
}

grpc::Status GrpcService::unknown_object(const std::string& name) const {
  std::string known;
  for (const std::string& one : table_.object_names()) known += (known.empty() ? "" : ", ") + one;
  return {grpc::StatusCode::NOT_FOUND,
          "object: \"" + printable(name) +
              "\" is not in the scene; it contains: " + (known.empty() ? "nothing yet" : known)};
}

grpc::Status GrpcService::analyze(const v1::AnalyzeObjectRequest& request,
                                  v1::AnalyzeObjectReply& reply) const {
  const int64_t begun_ns = now_ns();
  const SessionTable::Object object = table_.object(request.object());
  if (!object) return unknown_object(request.object());
  reply.set_object(object->name());
  *reply.mutable_parameters() = object->physics();
  if (object->has_elastic()) *reply.mutable_elastic() = object->elastic();
  *reply.mutable_warnings() = object->warnings();
  reply.set_elapsed_ms(milliseconds_from_ns(now_ns() - begun_ns));
  return grpc::Status::OK;
}

}  // namespace livegs
