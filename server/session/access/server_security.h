// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "core/result.h"
#include "session/access/token_store.h"

namespace livegs {

// A certificate of the user's own, PEM: with the certificates of its issuers, and its key, which other users
// may not read.
struct CertificateFiles {
  std::filesystem::path certificate, key;
};

// The identity of a server and its tokens: all files of its state folder. One server at a time uses a folder.
// - server.key, server.crt: self-signed certificate of an EC key on P-256, created at the first run; key
// 0600.
// - tokens.json: see token_store.h; 0600.
// - admin.token: token of scope admin, new at each start, for `livegs ctl` of the folder's owner; 0600.
// - running: locked while a server runs; contains its port and the fingerprint of its certificate.
class ServerSecurity {
 public:
  // PermissionDenied if other users may read the files or the folder is not writable. Unavailable if another
  // server uses the folder.
  // `own`: the certificate to use instead of the one of the folder. InvalidData if its key is another's.
  static Result<std::unique_ptr<ServerSecurity>> open(const std::filesystem::path& folder,
                                                      WallClock clock = system_wall_clock(),
                                                      const std::optional<CertificateFiles>& own = {});
  ~ServerSecurity();
  ServerSecurity(const ServerSecurity&) = delete;
  ServerSecurity& operator=(const ServerSecurity&) = delete;

  const std::string& certificate_pem() const { return certificate_pem_; }
  const std::string& key_pem() const { return key_pem_; }
  const std::string& fingerprint() const { return fingerprint_; }
  TokenStore& tokens() { return *tokens_; }
  void set_port(int port);  // published for find_local_server()

 private:
  ServerSecurity() = default;
  std::filesystem::path folder_;
  int lock_ = -1;
  std::string certificate_pem_, key_pem_, fingerprint_;
  std::unique_ptr<TokenStore> tokens_;
};

// Port and credentials with which `livegs ctl` connects to the server of this folder. NotFound if none runs.
struct LocalServer {
  int port = 0;
  std::string fingerprint, token;
};
Result<LocalServer> find_local_server(const std::filesystem::path& folder);

}  // namespace livegs
