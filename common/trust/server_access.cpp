// SPDX-License-Identifier: Apache-2.0
#include "trust/server_access.h"

#include <grpcpp/security/credentials.h>
#include <grpcpp/security/tls_certificate_verifier.h>
#include <grpcpp/security/tls_credentials_options.h>

#include <cstdlib>
#include <mutex>

#include "core/file.h"
#include "core/log.h"
#include "trust/fingerprint.h"
#include "trust/host_port.h"
#include "trust/known_servers.h"
#include "trust/state_folder.h"

namespace livegs {

struct ServerAccess::Pin {
  mutable std::mutex mutex;  // guards everything below
  std::string fingerprint;
  std::string code;
  bool found_by_code = false;
  std::string shown;  // fingerprint of the last rejected certificate; empty: none

  bool take(std::string_view pem) {
    const auto seen = certificate_fingerprint(pem);
    std::lock_guard lock(mutex);
    if (seen && fingerprint.empty() && fits_pairing_code(*seen, code)) {
      fingerprint = *seen;
      found_by_code = true;
    }
    if (seen && *seen == fingerprint) {
      shown.clear();
      return true;
    }
    shown = seen ? *seen : "none";
    return false;
  }
};

// Called by gRPC in each handshake, with the certificate for which the peer has proved to own the key.
class ServerAccess::Verifier final : public grpc::experimental::ExternalCertificateVerifier {
 public:
  explicit Verifier(std::shared_ptr<Pin> pin) : pin_(std::move(pin)) {}
  bool Verify(grpc::experimental::TlsCustomVerificationCheckRequest* request,
              std::function<void(grpc::Status)>, grpc::Status* status) override {
    const grpc::string_ref pem = request->peer_cert();
    *status = pin_->take({pem.data(), pem.size()}) ? grpc::Status::OK
                                                   : grpc::Status(grpc::StatusCode::UNAUTHENTICATED,
                                                                  "certificate does not match the known one");
    return true;  // completed synchronously
  }
  void Cancel(grpc::experimental::TlsCustomVerificationCheckRequest*) override {}

 private:
  std::shared_ptr<Pin> pin_;
};

ServerAccess::ServerAccess(std::string address, Keys keys)
    : address_(std::move(address)), token_(std::move(keys.token)), pin_(std::make_shared<Pin>()) {
  pin_->fingerprint = std::move(keys.fingerprint);
  pin_->code = std::move(keys.pairing_code);
}

std::shared_ptr<ServerAccess> ServerAccess::at(const std::string& address, const std::string& token) const {
  Keys keys;
  {
    std::lock_guard lock(pin_->mutex);
    keys = {pin_->fingerprint, pin_->code, token.empty() ? token_ : token};
  }
  return std::make_shared<ServerAccess>(address, std::move(keys));
}

std::shared_ptr<grpc::ChannelCredentials> ServerAccess::credentials() const {
  grpc::experimental::TlsChannelCredentialsOptions options;
  // no certificate authority is used; the verifier compares the certificate
  options.set_verify_server_certs(false);
  options.set_check_call_host(false);
  options.set_certificate_verifier(grpc::experimental::ExternalCertificateVerifier::Create<Verifier>(pin_));
  auto channel = grpc::experimental::TlsCredentials(options);
  if (token_.empty()) return channel;
  return grpc::CompositeChannelCredentials(channel, grpc::AccessTokenCredentials(token_));
}

Result<void> ServerAccess::refused() const {
  std::lock_guard lock(pin_->mutex);
  if (pin_->shown.empty()) return {};
  if (pin_->fingerprint.empty()) {
    return Error{
        ErrorCode::PermissionDenied,
        address_ +
            ": the certificate does not match the pairing code, so no data was sent; check the code, "
            "and the connection if the code is right"};
  }
  return Error{ErrorCode::PermissionDenied,
               address_ + ": the certificate differs from the paired one (known " +
                   pin_->fingerprint.substr(0, 16) + "…, shown " + pin_->shown.substr(0, 16) +
                   "…), so no data was sent; use --pair CODE if the server was set up again, else suspect an "
                   "interception"};
}

Result<void> ServerAccess::remember() const {
  if (file_.empty()) return {};
  KnownServer server;
  {
    std::lock_guard lock(pin_->mutex);
    server = {pin_->fingerprint, token_};
  }
  const KnownServers servers(file_);
  const auto before = servers.find(address_);
  if (!before) return before.error();
  if (*before && (*before)->fingerprint == server.fingerprint && (*before)->token == server.token) return {};
  log_info("%s: paired; certificate and token are saved in %s", address_.c_str(), file_.c_str());
  return servers.remember(address_, server);
}

namespace {

Result<std::string> given_token(const AccessOptions& options) {
  std::string token;
  if (!options.token_file.empty()) {
    auto text = read_text_file(options.token_file, 4096);
    if (!text) return text.error();
    token = text->substr(0, text->find_first_of("\r\n"));
    if (token.empty())
      return invalid_argument(options.token_file.string() +
                              ": the first line is empty; write the token there");
  } else if (const char* set = std::getenv("LIVEGS_TOKEN"); set != nullptr) {
    token = set;
  }
  for (const char c : token) {
    if (c <= ' ' || c > '~')
      return invalid_argument("token: contains an invalid character; use printable ASCII without spaces");
  }
  return token;
}

}  // namespace

Result<std::shared_ptr<ServerAccess>> choose_access(const std::string& address,
                                                    const AccessOptions& options) {
  const auto parsed = parse_host_port(address);
  if (!parsed) return parsed.error();
  auto token = given_token(options);
  if (!token) return token.error();
  if (!options.pairing_code.empty()) {
    if (auto checked = check_pairing_code(options.pairing_code); !checked) return checked.error();
  }
  auto folder = state_folder(options.state_dir);
  std::optional<KnownServer> known;
  if (folder) {
    const auto found = KnownServers(*folder / "known_servers").find(address);
    if (!found) return found.error();
    known = *found;
  } else if (!parsed->loopback || !options.pairing_code.empty()) {
    return folder.error();
  }
  if (options.pairing_code.empty() && !known) {
    if (parsed->loopback) return std::shared_ptr<ServerAccess>();
    return invalid_argument(address +
                            ": unknown remote server; pair with --pair CODE, using the code that the "
                            "server prints at start");
  }
  ServerAccess::Keys keys;
  if (options.pairing_code.empty()) keys.fingerprint = known->fingerprint;
  keys.pairing_code = options.pairing_code;
  keys.token = !token->empty() ? *token : known ? known->token : "";
  auto access = std::make_shared<ServerAccess>(address, std::move(keys));
  access->remember_in(*folder / "known_servers");
  return access;
}

Result<void> unpair_server(const std::string& address, const std::filesystem::path& state_dir) {
  auto folder = state_folder(state_dir);
  if (!folder) return folder.error();
  return KnownServers(*folder / "known_servers").remove_server_entry(address);
}

}  // namespace livegs
