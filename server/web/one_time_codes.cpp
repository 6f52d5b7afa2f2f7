// SPDX-License-Identifier: GPL-3.0-or-later
#include "web/one_time_codes.h"

#include <openssl/crypto.h>
#include <openssl/rand.h>

#include <array>
#include <cctype>

namespace livegs {
namespace {

// Without 0, O, 1 and I, which are easily confused.
constexpr std::string_view kLetters = "23456789ABCDEFGHJKLMNPQRSTUVWXYZ";
static_assert(kLetters.size() == 32);
constexpr size_t kLength = 8;

std::string letters_of(std::string_view typed) {
  std::string letters;
  for (const char c : typed) {
    if (c == ' ' || c == '-') continue;
    letters += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  }
  return letters;
}

}  // namespace

Result<std::string> OneTimeCodes::create() {
  std::array<unsigned char, kLength> random{};
  if (RAND_bytes(random.data(), kLength) != 1)
    return Error{ErrorCode::Internal, "pairing: the system has no random numbers"};
  std::string code;
  for (const unsigned char byte : random) code += kLetters[byte % kLetters.size()];
  std::lock_guard lock(mutex_);
  code_ = code;
  created_ns_ = clock_();
  tries_ = 0;
  return code;
}

Result<void> OneTimeCodes::use(std::string_view code) {
  const std::string letters = letters_of(code);
  std::lock_guard lock(mutex_);
  if (code_.empty() || clock_() - created_ns_ > kOneTimeCodeLifetime_ns) {
    code_.clear();
    return Error{ErrorCode::PermissionDenied,
                 "code: was used before or has expired; get another from the server with livegs ctl link"};
  }
  if (letters.size() == kLength && CRYPTO_memcmp(letters.data(), code_.data(), kLength) == 0) {
    code_.clear();
    return {};
  }
  if (++tries_ >= kMaxCodeTries) {
    code_.clear();
    return Error{ErrorCode::PermissionDenied,
                 "code: was wrong five times and is no longer valid; get another from the server with livegs "
                 "ctl link"};
  }
  return Error{ErrorCode::PermissionDenied,
               "code: is wrong; compare it with the one that the server printed"};
}

}  // namespace livegs
