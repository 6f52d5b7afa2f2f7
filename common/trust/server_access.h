// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "core/result.h"

namespace grpc {
class ChannelCredentials;
}

namespace livegs {

// TLS access to one server: the pinned certificate and the token. The certificate is verified in the
// handshake, before anything is sent, so the token cannot reach another server. Only the fingerprint counts;
// issuer, names and dates are ignored. Any thread.
class ServerAccess {
 public:
  struct Keys {
    std::string fingerprint;   // fingerprint of the certificate; or empty, with
    std::string pairing_code;  // the pairing code; the first certificate that matches it is pinned
    std::string token;         // empty: none
  };
  ServerAccess(std::string address, Keys keys);

  // Access to another server with the same certificate, as the servers of a fleet have it. Empty `token`:
  // that of this access. It is not saved.
  std::shared_ptr<ServerAccess> at(const std::string& address, const std::string& token) const;

  // Credentials for channels to the server; may be used for any number of channels.
  std::shared_ptr<grpc::ChannelCredentials> credentials() const;

  // The reason for the rejection of the last certificate. OK if there was none, or if it was accepted.
  Result<void> refused() const;

  // Saves the accepted certificate and token to the file of known servers, if there is one and they are new.
  Result<void> remember() const;
  void remember_in(std::filesystem::path file) { file_ = std::move(file); }

 private:
  struct Pin;
  class Verifier;
  std::string address_, token_;
  std::filesystem::path file_;
  std::shared_ptr<Pin> pin_;
};

struct AccessOptions {
  std::string pairing_code;          // empty: the server is known, or on this machine
  std::filesystem::path token_file;  // token in its first line; empty: LIVEGS_TOKEN, or the saved token
  std::filesystem::path state_dir;   // empty: the default folder of the user
};

// Selects the access to a server: by saved pairing data or by a pairing code. Null, which means no
// encryption, for an address of this machine without pairing. An error, and no data is sent, for any other
// address. A token is never passed on the command line, which every process may read.
Result<std::shared_ptr<ServerAccess>> choose_access(const std::string& address, const AccessOptions& options);

// Deletes the saved data of a server.
Result<void> unpair_server(const std::string& address, const std::filesystem::path& state_dir);

}  // namespace livegs
