// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/result.h"
#include "livegs/v1/admin.pb.h"

// Tokens for one server of a fleet. A service that places people signs them with a key that all servers of
// the fleet have, so that a server verifies them without a list and without a connection.
//
//   livegs_fleet_PAYLOAD.SIGNATURE     both in base64url
//
// PAYLOAD is a v1::FleetToken. SIGNATURE is HMAC-SHA256 (RFC 2104) of the text before the dot.

namespace livegs {

inline constexpr size_t kMinFleetKeyBytes = 32;  // as long as the hash: shorter keys weaken it (RFC 2104)

// The key of a fleet: the bytes of the file without a line break at its end. PermissionDenied if other users
// may read the file, InvalidData if it has fewer than kMinFleetKeyBytes.
Result<std::string> read_fleet_key(const std::filesystem::path& file);
// Writes a new random key with mode 0600. InvalidArgument if the file exists.
Result<void> write_fleet_key(const std::filesystem::path& file);

// InvalidArgument if a name is empty, too long or has characters that cannot be printed, or without a scope.
Result<std::string> sign_fleet_token(const std::string& key, const v1::FleetToken& token);

// True for a text in the form of these tokens; it may still be invalid. Tokens of a server's own list have
// no dot.
bool is_fleet_token(std::string_view text);

// The contents of a token that is signed with the key for this server and has not expired at `now_unix_s`.
// PermissionDenied otherwise; the message gives the cause for the log, not for the caller. Any bytes; the
// signature is compared in constant time, and nothing is decoded before it is valid.
Result<v1::FleetToken> verify_fleet_token(const std::string& key, const std::string& server,
                                          std::string_view text, int64_t now_unix_s);

}  // namespace livegs
