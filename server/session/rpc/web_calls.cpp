// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/rpc/web_calls.h"

#include <grpcpp/support/channel_arguments.h>

#include "core/clock.h"
#include "core/log.h"
#include "session/assets/asset_store.h"
#include "session/frames/send_budget.h"
#include "session/sessions/client_session.h"

namespace livegs {
namespace {

// Name of the tokens of paired browsers, in `livegs ctl tokens`.
constexpr const char* kBrowserToken = "browser";

class PacedFetch final : public WebFetch {
 public:
  PacedFetch(const AssetStore& assets, AssetStore::Bytes bytes, std::shared_ptr<SendBudget> budget,
             std::shared_ptr<ClientSession> session)
      : assets_(assets), bytes_(std::move(bytes)), budget_(std::move(budget)), session_(std::move(session)) {}
  ~PacedFetch() override { budget_->leave(this); }

  std::span<const std::byte> bytes() const override { return *bytes_; }
  Turn take_turn(size_t max_bytes) override {
    const int64_t now = now_ns();
    if (session_) session_->fetches(now);
    const SendBudget::Turn turn = budget_->take_turn(this, max_bytes, now);
    assets_.count_sent(turn.bytes);
    return {turn.bytes, turn.wait_ns};
  }

 private:
  const AssetStore& assets_;
  const AssetStore::Bytes bytes_;
  const std::shared_ptr<SendBudget> budget_;
  const std::shared_ptr<ClientSession> session_;
};

}  // namespace

WebCalls::WebCalls(grpc::Server& server, SessionTable& table, const AssetStore& assets, GrpcService& service,
                   ServerSecurity* security)
    : server_(server),
      table_(table),
      assets_(assets),
      service_(service),
      security_(security),
      codes_(now_ns) {
  if (security_) authoriser_ = std::make_unique<CallAuthoriser>(security_->tokens());
}

std::shared_ptr<grpc::Channel> WebCalls::channel() {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);
  return server_.InProcessChannel(arguments);
}

grpc::Status WebCalls::authorise(const std::string& path, const std::string& authorization) {
  if (!authoriser_) return grpc::Status::OK;
  CallAuthoriser::InputMetadata metadata;
  metadata.emplace(":path", path);
  if (!authorization.empty()) metadata.emplace("authorization", authorization);
  return authoriser_->Process(metadata, nullptr, nullptr, nullptr);
}

std::unique_ptr<WebFetch> WebCalls::fetch(const std::string& hash, const std::string& base,
                                          const std::string& session, const std::string& authorization) {
  auto bytes = assets_.find_bytes(hash, base);
  if (!bytes) return nullptr;
  std::shared_ptr<ClientSession> own;
  if (!session.empty()) {
    const auto who = security_ ? security_->tokens().check(bearer_token(authorization))
                               : Result<Authorization>(Authorization{});
    own = table_.find(session);
    if (!who || !own || own->who.authorization.token_id != who->token_id) own = nullptr;
  }
  auto budget = own ? own->budget : service_.peer_budget("web:");
  return std::make_unique<PacedFetch>(assets_, std::move(bytes), std::move(budget), std::move(own));
}

Result<std::string> WebCalls::pair(std::string_view code) {
  if (!security_)
    return invalid_argument(
        "code: is not needed, as this server requires no token; open its page without a code");
  if (auto used = codes_.use(code); !used) return used.error();
  auto made = security_->tokens().add(kBrowserToken, v1::INTERACT, kTokenDays);
  if (!made) return made.error();
  log_info("a browser was paired; its token is %.8s", made->token.id().c_str());
  return made->secret;
}

std::string WebCalls::new_one_time_code() {
  if (!security_) return "";
  auto code = codes_.create();
  if (!code) log_warn("%s", code.error().message.c_str());
  return code ? *code : "";
}

}  // namespace livegs
