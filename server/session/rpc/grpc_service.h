// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <limits>

#include "livegs/v1/session.grpc.pb.h"
#include "session/access/token_store.h"
#include "session/assets/asset_store.h"
#include "session/assets/client_store.h"
#include "session/rpc/author_calls.h"
#include "session/sessions/peer_budgets.h"
#include "session/sessions/session_table.h"
#include "session/tick/analysis_control.h"
#include "session/tick/run_control.h"

namespace livegs {

// livegs.v1.LiveGs over gRPC's callback API. Calls are served from the session table and the asset store;
// none blocks on the simulation.
class GrpcService final
    : public v1::LiveGs::WithRawCallbackMethod_Stream<v1::LiveGs::WithCallbackMethod_GetServerInfo<
          v1::LiveGs::WithCallbackMethod_Join<v1::LiveGs::WithCallbackMethod_FetchAsset<
              v1::LiveGs::WithCallbackMethod_AnalyzeObject<v1::LiveGs::WithCallbackMethod_AnalyzeScene<
                  v1::LiveGs::WithCallbackMethod_SetPhysics<v1::LiveGs::WithCallbackMethod_UndoPhysics<
                      v1::LiveGs::WithCallbackMethod_ControlRun<v1::LiveGs::WithCallbackMethod_AcceptProposal<
                          v1::LiveGs::WithCallbackMethod_ApplyForce<AuthorCalls>>>>>>>>>>> {
 public:
  // `tokens` is null without TLS.
  GrpcService(SessionTable& table, const AssetStore& assets, const TokenStore* tokens)
      : table_(table), assets_(assets), tokens_(tokens) {}

  grpc::ServerUnaryReactor* GetServerInfo(grpc::CallbackServerContext* context,
                                          const v1::GetServerInfoRequest* request,
                                          v1::ServerInfo* reply) override;
  grpc::ServerUnaryReactor* Join(grpc::CallbackServerContext* context, const v1::JoinRequest* request,
                                 v1::JoinReply* reply) override;
  grpc::ServerWriteReactor<v1::AssetChunk>* FetchAsset(grpc::CallbackServerContext* context,
                                                       const v1::FetchAssetRequest* request) override;
  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* Stream(
      grpc::CallbackServerContext* context) override;
  grpc::ServerUnaryReactor* AnalyzeObject(grpc::CallbackServerContext* context,
                                          const v1::AnalyzeObjectRequest* request,
                                          v1::AnalyzeObjectReply* reply) override;
  grpc::ServerWriteReactor<v1::AnalysisProgress>* AnalyzeScene(
      grpc::CallbackServerContext* context, const v1::AnalyzeSceneRequest* request) override;
  grpc::ServerUnaryReactor* SetPhysics(grpc::CallbackServerContext* context,
                                       const v1::SetPhysicsRequest* request,
                                       v1::PhysicsReply* reply) override;
  grpc::ServerUnaryReactor* AcceptProposal(grpc::CallbackServerContext* context,
                                           const v1::AcceptProposalRequest* request,
                                           v1::PhysicsReply* reply) override;
  grpc::ServerUnaryReactor* UndoPhysics(grpc::CallbackServerContext* context,
                                        const v1::UndoPhysicsRequest* request,
                                        v1::PhysicsReply* reply) override;

  grpc::ServerUnaryReactor* ControlRun(grpc::CallbackServerContext* context,
                                       const v1::ControlRunRequest* request, v1::RunState* reply) override;
  grpc::ServerUnaryReactor* ApplyForce(grpc::CallbackServerContext* context,
                                       const v1::ApplyForceRequest* request,
                                       v1::ApplyForceReply* reply) override;

  // Upper limit of a client's stream and fetches together, bytes a second; the client may request less. Also
  // the limit of all fetches without a session from one machine. Call before the first Join.
  void set_cap(double bytes_s) { cap_bytes_s_ = bytes_s; }
  // The store from which clients fetch assets. Call before the first Join.
  void set_store(ClientStore store) { store_ = std::move(store); }
  // The bandwidth limit of fetches of this caller without a session. Any thread.
  std::shared_ptr<SendBudget> peer_budget(std::string_view peer) {
    return peer_budgets_.of(peer, cap_bytes_s_);
  }
  // Enables pause, step and reset; null disables them. Must outlive the calls.
  void set_run(RunControl* run) { run_ = run; }
  // Whether a client has joined that starts a waiting run (JoinRequest.starts_run) and may.
  bool starter_joined() const { return starter_joined_; }
  // Enables analysis and edits of values; null disables them. Must outlive the calls.
  void set_analysis(AnalysisControl* analysis) { analysis_ = analysis; }

 private:
  grpc::Status join(const grpc::CallbackServerContext& context, const v1::JoinRequest& request,
                    v1::JoinReply& reply);
  // The session that a call names in its metadata; null for none, or for one of another token.
  std::shared_ptr<ClientSession> session_of(const grpc::CallbackServerContext& context) const;
  grpc::Status control_run(const v1::ControlRunRequest& request, v1::RunState& reply) const;
  grpc::Status apply_force(const v1::ApplyForceRequest& request, v1::ApplyForceReply& reply) const;
  grpc::Status unknown_object(const std::string& name) const;
  grpc::Status analyze(const v1::AnalyzeObjectRequest& request, v1::AnalyzeObjectReply& reply) const;

  SessionTable& table_;
  const AssetStore& assets_;
  const TokenStore* const tokens_;
  PeerBudgets peer_budgets_;
  ClientStore store_;
  double cap_bytes_s_ = std::numeric_limits<double>::infinity();
  std::atomic<AnalysisControl*> analysis_ = nullptr;
  std::atomic<RunControl*> run_ = nullptr;
  std::atomic<bool> starter_joined_ = false;
};

}  // namespace livegs
