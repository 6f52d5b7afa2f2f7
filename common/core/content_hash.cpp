// SPDX-License-Identifier: Apache-2.0
#include "core/content_hash.h"

#include <openssl/evp.h>

#include "core/assert.h"

namespace livegs {

std::string hexadecimal(std::span<const std::byte> bytes) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  text.reserve(2 * bytes.size());
  for (const std::byte byte : bytes) {
    text += kDigits[std::to_integer<unsigned>(byte) >> 4];
    text += kDigits[std::to_integer<unsigned>(byte) & 15];
  }
  return text;
}

std::string content_hash(std::span<const std::byte> bytes) {
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int size = 0;
  const int done = EVP_Digest(bytes.data(), bytes.size(), digest, &size, EVP_sha256(), nullptr);
  LIVEGS_ASSERT(done == 1 && size == 32);
  return hexadecimal(std::as_bytes(std::span(digest, size)));
}

}  // namespace livegs
