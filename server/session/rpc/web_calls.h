// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <grpcpp/server.h>

#include <memory>
#include <string>

#include "session/access/call_authoriser.h"
#include "session/access/server_security.h"
#include "session/rpc/grpc_service.h"
#include "web/one_time_codes.h"
#include "web/web_server.h"

namespace livegs {

// Calls of browsers, with the rights, limits and answers of gRPC clients: RPCs go through a channel within
// the process. That channel has no credentials, so authorise() checks each call first, as gRPC does for its
// own connections.
class WebCalls final : public WebBackend {
 public:
  // `security`: null without TLS. The rest outlives this.
  WebCalls(grpc::Server& server, SessionTable& table, const AssetStore& assets, GrpcService& service,
           ServerSecurity* security);

  std::shared_ptr<grpc::Channel> channel() override;
  grpc::Status authorise(const std::string& path, const std::string& authorization) override;
  std::unique_ptr<WebFetch> fetch(const std::string& hash, const std::string& base,
                                  const std::string& session, const std::string& authorization) override;
  Result<std::string> pair(std::string_view code) override;
  std::string new_one_time_code();  // GrpcServer::new_one_time_code()

 private:
  grpc::Server& server_;
  SessionTable& table_;
  const AssetStore& assets_;
  GrpcService& service_;
  ServerSecurity* const security_;
  std::unique_ptr<CallAuthoriser> authoriser_;  // null without TLS
  OneTimeCodes codes_;
};

}  // namespace livegs
