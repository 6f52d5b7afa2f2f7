// SPDX-License-Identifier: Apache-2.0
#include "trust/known_servers.h"

#include <map>
#include <sstream>

#include "trust/state_folder.h"

namespace livegs {
namespace {

using Known = std::map<std::string, KnownServer>;

Result<Known> read(const std::filesystem::path& file) {
  Known known;
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return known;
  auto text = read_secret_file(file);
  if (!text) return text.error();
  std::istringstream lines(*text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (line.empty()) continue;
    std::istringstream words(line);
    std::string address, more;
    KnownServer server;
    words >> address >> server.fingerprint >> server.token;
    if (server.token.empty() || words >> more || server.fingerprint.size() != 64 ||
        server.fingerprint.find_first_not_of("0123456789abcdef") != std::string::npos) {
      return invalid_data(file.string() + ":" + std::to_string(number) +
                          ": must be HOST:PORT FINGERPRINT TOKEN; remove the line and pair again");
    }
    if (server.token == "-") server.token.clear();
    known[address] = server;
  }
  return known;
}

Result<void> write(const std::filesystem::path& file, const Known& known) {
  std::string text;
  for (const auto& [address, server] : known) {
    text += address + " " + server.fingerprint + " " + (server.token.empty() ? "-" : server.token) + "\n";
  }
  return write_secret_file(file, text);
}

}  // namespace

Result<std::optional<KnownServer>> KnownServers::find(const std::string& address) const {
  const auto known = read(file_);
  if (!known) return known.error();
  const auto found = known->find(address);
  if (found == known->end()) return std::optional<KnownServer>();
  return std::optional<KnownServer>(found->second);
}

Result<void> KnownServers::remember(const std::string& address, const KnownServer& server) const {
  auto known = read(file_);
  if (!known) return known.error();
  (*known)[address] = server;
  return write(file_, *known);
}

Result<void> KnownServers::remove_server_entry(const std::string& address) const {
  auto known = read(file_);
  if (!known) return known.error();
  if (known->erase(address) == 0)
    return not_found(address + ": is not a paired server; give HOST:PORT as it was paired");
  return write(file_, *known);
}

}  // namespace livegs
