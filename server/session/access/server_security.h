// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "core/result.h"
#include "session/access/token_store.h"

namespace livegs {

// Who a server is, and whom it lets in: everything in its state folder. One server at a time has it.
//   server.key, server.crt   a self-signed certificate of an EC key on P-256, made at the first run; key 0600
//   tokens.json              see token_store.h; 0600
//   admin.token              of scope admin, new at each start, for `livegs ctl` of whoever owns the folder;
//   0600 running                  locked while a server runs; holds its port
class ServerSecurity {
 public:
  // PermissionDenied when files are others' to read or the folder cannot be written, Unavailable while
  // another server has it.
  static Result<std::unique_ptr<ServerSecurity>> open(const std::filesystem::path& folder,
                                                      WallClock clock = system_wall_clock());
  ~ServerSecurity();
  ServerSecurity(const ServerSecurity&) = delete;
  ServerSecurity& operator=(const ServerSecurity&) = delete;

  const std::string& certificate_pem() const { return certificate_pem_; }
  const std::string& key_pem() const { return key_pem_; }
  const std::string& fingerprint() const { return fingerprint_; }
  TokenStore& tokens() { return *tokens_; }
  void set_port(int port);  // for who looks for the running server

 private:
  ServerSecurity() = default;
  std::filesystem::path folder_;
  int lock_ = -1;
  std::string certificate_pem_, key_pem_, fingerprint_;
  std::unique_ptr<TokenStore> tokens_;
};

// What `livegs ctl` of whoever owns the folder reaches its server with. NotFound when none runs there.
struct LocalServer {
  int port = 0;
  std::string fingerprint, token;
};
Result<LocalServer> find_local_server(const std::filesystem::path& folder);

}  // namespace livegs
