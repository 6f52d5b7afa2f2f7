// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/result.h"

namespace livegs {

// What a client remembers of a server it has paired with.
struct KnownServer {
  std::string fingerprint;  // of its certificate, 64 hexadecimal digits
  std::string token;        // empty: none
};

// One line a server, "HOST:PORT FINGERPRINT TOKEN", a dash for no token, in a file of mode 0600. An address
// is compared as it was given.
class KnownServers {
 public:
  explicit KnownServers(std::filesystem::path file) : file_(std::move(file)) {}

  // Nothing when it is not known. An error, which names the file and the line, when the file cannot be read
  // as such.
  Result<std::optional<KnownServer>> find(const std::string& address) const;
  Result<void> remember(const std::string& address, const KnownServer& server) const;
  Result<void> remove_server_entry(const std::string& address) const;

 private:
  std::filesystem::path file_;
};

}  // namespace livegs
