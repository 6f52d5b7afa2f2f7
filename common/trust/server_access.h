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

// How a client reaches one server over TLS: the certificate it insists on and the token it shows. The
// certificate is looked at in the handshake, before anything is sent, so that a token goes to nobody else.
// Who signed it, its names and its dates do not matter: it is the one, or it is not. Any thread.
class ServerAccess {
 public:
  struct Keys {
    std::string fingerprint;   // the certificate's; or empty, and
    std::string pairing_code;  // the code that it has to fit; the first that does is insisted on from then on
    std::string token;         // empty: none
  };
  ServerAccess(std::string address, Keys keys);

  // For a channel to the server. It may be used for any number.
  std::shared_ptr<grpc::ChannelCredentials> credentials() const;

  // Why the last certificate that was shown is not taken; OK when none was or it was the right one.
  Result<void> refused() const;

  // Writes what was found good to the file of known servers, if there is one and something in it is new.
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
  std::filesystem::path token_file;  // its first line; empty: LIVEGS_TOKEN, or what is remembered
  std::filesystem::path state_dir;   // empty: the user's
};

// What to reach a server with: as it was paired with, or by a pairing code. Null, which is in the clear, for
// an address of this machine that was never paired with. An error, and nothing is sent, for any other. A
// token is never taken from a command line, which every process may read.
Result<std::shared_ptr<ServerAccess>> choose_access(const std::string& address, const AccessOptions& options);

// Takes back what was remembered of a server.
Result<void> forget_server(const std::string& address, const std::filesystem::path& state_dir);

}  // namespace livegs
