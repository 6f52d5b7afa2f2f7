// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/result.h"

namespace livegs {

// Stored data of a paired server.
struct KnownServer {
  std::string fingerprint;  // of its certificate, 64 hexadecimal digits
  std::string token;        // empty: none
};

// The list of paired servers in a file of mode 0600, one per line: "HOST:PORT FINGERPRINT TOKEN", with a dash
// for no token. Addresses are compared literally.
class KnownServers {
 public:
  explicit KnownServers(std::filesystem::path file) : file_(std::move(file)) {}

  // Empty if the server is unknown. An error, with the file and the line, if the file cannot be parsed.
  Result<std::optional<KnownServer>> find(const std::string& address) const;
  Result<void> remember(const std::string& address, const KnownServer& server) const;
  Result<void> remove_server_entry(const std::string& address) const;

 private:
  std::filesystem::path file_;
};

}  // namespace livegs
