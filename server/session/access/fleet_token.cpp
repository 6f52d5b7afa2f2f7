// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/access/fleet_token.h"

#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <openssl/rand.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "core/assert.h"
#include "core/text/shown_text.h"
#include "session/access/base64_url.h"
#include "trust/fingerprint.h"
#include "trust/state_folder.h"

namespace livegs {
namespace {

constexpr std::string_view kFleetPrefix = "livegs_fleet_";
constexpr size_t kMaxFleetTokenBytes = 1024;  // both names at their longest need about half
constexpr size_t kMaxPersonName = 64;
constexpr size_t kMaxServerName = 253;  // of a Kubernetes object

std::string signature_of(const std::string& key, std::string_view text) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> hash;
  unsigned size = 0;
  const unsigned char* made =
      HMAC(EVP_sha256(), key.data(), static_cast<int>(key.size()),
           reinterpret_cast<const unsigned char*>(text.data()), text.size(), hash.data(), &size);
  LIVEGS_ASSERT(made != nullptr);
  return base64_url({hash.data(), size});
}

bool is_printable_name(const std::string& name, size_t max_bytes) {
  return !name.empty() && name.size() <= max_bytes &&
         std::all_of(name.begin(), name.end(), [](unsigned char c) { return std::isprint(c) != 0; });
}

Error fleet_refusal(std::string cause) {
  return {ErrorCode::PermissionDenied, "fleet token: " + std::move(cause)};
}

}  // namespace

Result<std::string> read_fleet_key(const std::filesystem::path& file) {
  auto key = read_secret_file(file);
  if (!key) return key.error();
  while (!key->empty() && (key->back() == '\n' || key->back() == '\r')) key->pop_back();
  if (key->size() < kMinFleetKeyBytes)
    return invalid_data(file.string() +
                        ": is shorter than 32 bytes; create a key with livegs token --new-key FILE");
  return key;
}

Result<void> write_fleet_key(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::exists(file, error))
    return invalid_argument(file.string() +
                            ": exists; choose another file, since its tokens would become invalid");
  std::array<unsigned char, kMinFleetKeyBytes> bytes;
  const int drawn = RAND_bytes(bytes.data(), static_cast<int>(bytes.size()));
  LIVEGS_ASSERT(drawn == 1);
  return write_secret_file(std::filesystem::absolute(file), base64_url(bytes) + "\n");
}

Result<std::string> sign_fleet_token(const std::string& key, const v1::FleetToken& token) {
  if (!is_printable_name(token.name(), kMaxPersonName))
    return invalid_argument("name: must have 1 to 64 printable characters; use the name of the person");
  if (!is_printable_name(token.server(), kMaxServerName))
    return invalid_argument(
        "server: must have 1 to 253 printable characters; use the name of the GameServer or of "
        "--server-name");
  if (token.scope() < v1::VIEW || token.scope() > v1::ADMIN)
    return invalid_argument("scope: is not set or unknown; use view, interact, author or admin");
  const std::string payload = token.SerializeAsString();
  const std::string text =
      std::string(kFleetPrefix) +
      base64_url({reinterpret_cast<const unsigned char*>(payload.data()), payload.size()});
  return text + "." + signature_of(key, text);
}

bool is_fleet_token(std::string_view text) {
  return text.starts_with(kFleetPrefix) && text.find('.') != std::string_view::npos;
}

Result<v1::FleetToken> verify_fleet_token(const std::string& key, const std::string& server,
                                          std::string_view text, int64_t now_unix_s) {
  const size_t dot = text.find('.');
  if (!is_fleet_token(text) || text.size() > kMaxFleetTokenBytes)
    return fleet_refusal("is not in the form of one; give all of the text that livegs token printed");
  const std::string_view signed_text = text.substr(0, dot);
  if (!equal_in_constant_time(signature_of(key, signed_text), text.substr(dot + 1)))
    return fleet_refusal(
        "the signature is wrong, as the token was altered or signed with another key; sign one with the file "
        "of --fleet-key");
  const auto payload = from_base64_url(signed_text.substr(kFleetPrefix.size()));
  v1::FleetToken token;
  if (!payload || !token.ParseFromString(*payload))
    return fleet_refusal("has no readable contents; sign a new one with livegs token");
  if (token.server() != server)
    return fleet_refusal("is for server " + quoted_name(token.server()) + ", not for " + quoted_name(server) +
                         "; sign one for this server with livegs token");
  if (now_unix_s >= token.expires_unix_s())
    return fleet_refusal("of " + quoted_name(token.name()) +
                         " has expired; sign a new one with livegs token");
  if (token.scope() < v1::VIEW || token.scope() > v1::ADMIN)
    return fleet_refusal("has no known scope; sign a new one with livegs token");
  return token;
}

}  // namespace livegs
