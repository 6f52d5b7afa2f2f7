// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <mutex>
#include <string>

#include "livegs/v1/admin.grpc.pb.h"
#include "session/access/server_security.h"
#include "session/recording/session_recorder.h"
#include "session/sessions/session_table.h"

namespace livegs {

// livegs.v1.Admin, used by `livegs ctl`. CallAuthoriser checks the caller. Without TLS every local caller may
// use it, except for tokens, which would outlive this server. No call blocks.
class AdminService final
    : public v1::Admin::WithCallbackMethod_GetStatus<v1::Admin::WithCallbackMethod_KickClient<
          v1::Admin::WithCallbackMethod_AddToken<v1::Admin::WithCallbackMethod_ListTokens<
              v1::Admin::WithCallbackMethod_RevokeToken<v1::Admin::WithCallbackMethod_Drain<
                  v1::Admin::WithCallbackMethod_StartRecording<v1::Admin::WithCallbackMethod_StopRecording<
                      v1::Admin::WithCallbackMethod_AddBrowserLink<v1::Admin::Service>>>>>>>>> {
 public:
  using Drainer = std::function<void(const std::string& reason)>;
  // `security` is null without TLS.
  AdminService(SessionTable& table, ServerSecurity* security, SessionRecorder& recorder);

  void set_drain(Drainer drain);
  using Linker = std::function<v1::BrowserLink()>;
  void set_linker(Linker linker);

  grpc::ServerUnaryReactor* GetStatus(grpc::CallbackServerContext* context,
                                      const v1::GetStatusRequest* request, v1::ServerStatus* reply) override;
  grpc::ServerUnaryReactor* KickClient(grpc::CallbackServerContext* context,
                                       const v1::KickClientRequest* request,
                                       v1::KickClientReply* reply) override;
  grpc::ServerUnaryReactor* AddToken(grpc::CallbackServerContext* context, const v1::AddTokenRequest* request,
                                     v1::AddTokenReply* reply) override;
  grpc::ServerUnaryReactor* ListTokens(grpc::CallbackServerContext* context,
                                       const v1::ListTokensRequest* request, v1::TokenList* reply) override;
  grpc::ServerUnaryReactor* RevokeToken(grpc::CallbackServerContext* context,
                                        const v1::RevokeTokenRequest* request, v1::Token* reply) override;
  grpc::ServerUnaryReactor* Drain(grpc::CallbackServerContext* context, const v1::DrainRequest* request,
                                  v1::DrainReply* reply) override;
  grpc::ServerUnaryReactor* StartRecording(grpc::CallbackServerContext* context,
                                           const v1::StartRecordingRequest* request,
                                           v1::RecordingStatus* reply) override;
  grpc::ServerUnaryReactor* StopRecording(grpc::CallbackServerContext* context,
                                          const v1::StopRecordingRequest* request,
                                          v1::RecordingStatus* reply) override;

  grpc::ServerUnaryReactor* AddBrowserLink(grpc::CallbackServerContext* context,
                                           const v1::AddBrowserLinkRequest* request,
                                           v1::BrowserLink* reply) override;

 private:
  SessionTable& table_;
  ServerSecurity* const security_;
  SessionRecorder& recorder_;
  const int64_t started_ns_;
  std::mutex mutex_;  // guards everything below
  Drainer drain_;
  Linker linker_;
};

}  // namespace livegs
