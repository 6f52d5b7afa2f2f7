// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/access/token_store.h"

#include <google/protobuf/util/json_util.h>
#include <openssl/rand.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <cmath>
#include <span>

#include "core/assert.h"
#include "core/clock.h"
#include "core/content_hash.h"
#include "core/file.h"
#include "core/log.h"
#include "session/access/base64_url.h"
#include "session/access/fleet_token.h"
#include "session/access/id_prefix.h"
#include "trust/fingerprint.h"
#include "trust/state_folder.h"

namespace livegs {
namespace {

constexpr std::string_view kPrefix = "livegs_";  // recognisable to people and to secret scanners
constexpr size_t kSecretBytes = 32;
constexpr size_t kMaxName = 64;
constexpr int64_t kDay_s = 86400;
constexpr int64_t kExpiredTokenRetention_s = 30 * kDay_s;  // after expiry
constexpr const char* kScopeNames[] = {"view", "interact", "author", "admin"};

template <size_t kBytes>
std::array<unsigned char, kBytes> random_bytes() {
  std::array<unsigned char, kBytes> bytes;
  const int drawn = RAND_bytes(bytes.data(), kBytes);
  LIVEGS_ASSERT(drawn == 1);
  return bytes;
}

std::string token_text() { return std::string(kPrefix) + base64_url(random_bytes<kSecretBytes>()); }

std::string token_id() {
  const auto bytes = random_bytes<4>();
  return content_hash(std::as_bytes(std::span(bytes))).substr(0, 8);
}

std::string hash_of(std::string_view secret) {
  return content_hash(std::as_bytes(std::span(secret.data(), secret.size())));
}

Authorization authorization_of(const v1::Token& token) { return {token.id(), token.name(), token.scope()}; }

Error denied(std::string message) { return {ErrorCode::PermissionDenied, std::move(message)}; }

// The same for every token that is not accepted, so that a caller cannot find out how close a guess was.
Error unknown_token() {
  return denied(
      "token: is not known to this server; check that it is complete, or ask the server's operator for a "
      "new one");
}

}  // namespace

std::string scope_name(v1::Scope scope) {
  return scope >= v1::VIEW && scope <= v1::ADMIN ? kScopeNames[scope - v1::VIEW] : "none";
}

Result<v1::Scope> parse_scope(const std::string& name) {
  for (int i = 0; i < 4; ++i) {
    if (name == kScopeNames[i]) return static_cast<v1::Scope>(v1::VIEW + i);
  }
  return invalid_argument("scope: \"" + name + "\" is unknown; use view, interact, author or admin");
}

WallClock system_wall_clock() {
  return [] {
    return std::chrono::duration_cast<std::chrono::seconds>(
               std::chrono::system_clock::now().time_since_epoch())
        .count();
  };
}

Result<std::unique_ptr<TokenStore>> TokenStore::open(std::filesystem::path file, WallClock clock) {
  std::unique_ptr<TokenStore> store(new TokenStore(std::move(file), std::move(clock)));
  std::error_code error;
  if (!std::filesystem::exists(store->file_, error)) return store;
  const auto text = read_secret_file(store->file_);
  if (!text) return text.error();
  const auto parsed = google::protobuf::util::JsonStringToMessage(*text, &store->tokens_);
  if (!parsed.ok()) {
    return invalid_data(store->file_.string() + ": is not a list of tokens: " +
                        std::string(parsed.message()) + "; remove the file to invalidate all tokens");
  }
  return store;
}

Result<void> TokenStore::write() const {
  google::protobuf::util::JsonPrintOptions options;
  options.add_whitespace = options.preserve_proto_field_names = true;
  std::string text;
  const auto printed = google::protobuf::util::MessageToJsonString(tokens_, &text, options);
  LIVEGS_ASSERT(printed.ok());
  return write_secret_file(file_, text);
}

Result<TokenStore::Made> TokenStore::add(const std::string& name, v1::Scope scope, double days) {
  if (name.empty() || name.size() > kMaxName ||
      !std::all_of(name.begin(), name.end(), [](unsigned char c) { return std::isprint(c) != 0; })) {
    return invalid_argument(
        "name: must have 1 to 64 printable characters; use the name of the user or device");
  }
  if (scope < v1::VIEW || scope > v1::ADMIN)
    return invalid_argument("scope: is not set or unknown; use view, interact, author or admin");
  if (days == 0) days = kTokenDays;
  if (!(days > 0 && days <= kMaxTokenDays)) return invalid_argument("days: must be above 0 and at most 3650");
  Made made;
  made.secret = token_text();
  const int64_t now_s = clock_();
  made.token.set_id(token_id());
  made.token.set_name(name);
  made.token.set_scope(scope);
  made.token.set_made_unix_s(now_s);
  made.token.set_expires_unix_s(now_s + static_cast<int64_t>(std::ceil(days * kDay_s)));
  std::lock_guard lock(mutex_);
  const v1::TokenFile before = tokens_;
  auto& tokens = *tokens_.mutable_tokens();
  tokens.erase(std::remove_if(tokens.begin(), tokens.end(),
                              [&](const v1::Token& token) {
                                return token.expires_unix_s() + kExpiredTokenRetention_s < now_s;
                              }),
               tokens.end());
  if (static_cast<size_t>(tokens.size()) >= kMaxTokens) {
    tokens_ = before;
    return Error{ErrorCode::TooLarge,
                 "tokens: the limit of 1000 is reached; wait until expired tokens are removed"};
  }
  v1::Token& kept = *tokens.Add();
  kept = made.token;
  kept.set_sha256(hash_of(made.secret));
  if (auto written = write(); !written) {
    tokens_ = before;
    return written.error();
  }
  return made;
}

std::string TokenStore::add_local_admin() {
  const std::string secret = token_text();
  std::lock_guard lock(mutex_);
  local_admin_.set_id("local");
  local_admin_.set_name("local admin");
  local_admin_.set_scope(v1::ADMIN);
  local_admin_.set_sha256(hash_of(secret));
  return secret;
}

Result<v1::Token> TokenStore::revoke(const std::string& id) {
  std::lock_guard lock(mutex_);
  std::vector<std::string> ids;
  for (const v1::Token& token : tokens_.tokens()) ids.push_back(token.id());
  const auto found = find_by_prefix(ids, id, "token", "livegs ctl tokens list");
  if (!found) return found.error();
  v1::Token& token = *tokens_.mutable_tokens(static_cast<int>(*found));
  token.set_revoked(true);  // before the write: if it fails, the token is still refused until the server ends
  if (auto written = write(); !written) return written.error();
  v1::Token revoked = token;
  revoked.clear_sha256();
  return revoked;
}

std::vector<v1::Token> TokenStore::list() const {
  std::lock_guard lock(mutex_);
  std::vector<v1::Token> tokens(tokens_.tokens().begin(), tokens_.tokens().end());
  for (v1::Token& token : tokens) token.clear_sha256();
  return tokens;
}

Result<void> TokenStore::check_record(const v1::Token& token) const {
  if (token.revoked())
    return denied("token \"" + token.name() + "\": was revoked; ask the server's operator for a new one");
  if (token.id() != local_admin_.id() && clock_() >= token.expires_unix_s()) {
    return denied("token \"" + token.name() + "\": has expired; ask the server's operator for a new one");
  }
  return {};
}

void TokenStore::accept_fleet(std::string key, std::string server) {
  std::lock_guard lock(mutex_);
  fleet_key_ = std::move(key);
  fleet_server_ = std::move(server);
}

Result<Authorization> TokenStore::check_fleet(std::string_view secret) const {
  std::lock_guard lock(mutex_);
  if (fleet_key_.empty()) return unknown_token();
  const auto token = verify_fleet_token(fleet_key_, fleet_server_, secret, clock_());
  if (!token) {
    if (refusals_logged_.try_take(now_ns())) log_warn("%s", token.error().message.c_str());
    return unknown_token();
  }
  Authorization authorization{hash_of(secret).substr(0, 16), token->name(), token->scope()};
  authorization.fleet_expiry_unix_s = token->expires_unix_s();
  return authorization;
}

Result<std::string> TokenStore::fleet_token_for(const std::string& server,
                                                const Authorization& authorization) const {
  std::lock_guard lock(mutex_);
  if (fleet_key_.empty() || authorization.fleet_expiry_unix_s == 0)
    return not_found("token: is not one of a fleet");
  v1::FleetToken token;
  token.set_server(server);
  token.set_name(authorization.token_name);
  token.set_scope(authorization.scope);
  token.set_expires_unix_s(authorization.fleet_expiry_unix_s);
  return sign_fleet_token(fleet_key_, token);
}

Result<Authorization> TokenStore::check(std::string_view secret) const {
  if (secret.empty()) {
    return denied(
        "token: is required; pass --token-file FILE or set LIVEGS_TOKEN (create one with livegs ctl tokens "
        "add)");
  }
  if (is_fleet_token(secret)) return check_fleet(secret);
  const std::string hash = hash_of(secret);
  std::lock_guard lock(mutex_);
  const v1::Token* found = nullptr;
  for (const v1::Token& token : tokens_.tokens()) {
    if (equal_in_constant_time(token.sha256(), hash)) found = &token;
  }
  if (equal_in_constant_time(local_admin_.sha256(), hash)) found = &local_admin_;
  if (found == nullptr) return unknown_token();
  if (auto good = check_record(*found); !good) return good.error();
  return authorization_of(*found);
}

Result<void> TokenStore::check_still(const Authorization& authorization) const {
  if (authorization.fleet_expiry_unix_s != 0) {
    if (clock_() < authorization.fleet_expiry_unix_s) return {};
    return denied("token \"" + authorization.token_name +
                  "\": has expired; ask the server's operator for a new one");
  }
  std::lock_guard lock(mutex_);
  if (authorization.token_id == local_admin_.id()) return {};
  for (const v1::Token& token : tokens_.tokens()) {
    if (token.id() == authorization.token_id) return check_record(token);
  }
  return denied("token: is no longer known to this server; ask the server's operator for a new one");
}

}  // namespace livegs
