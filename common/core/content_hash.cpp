// SPDX-License-Identifier: Apache-2.0
#include "core/content_hash.h"

#include <openssl/evp.h>

#include "core/assert.h"

namespace livegs {

std::string content_hash(std::span<const std::byte> bytes) {
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int size = 0;
  const int done = EVP_Digest(bytes.data(), bytes.size(), digest, &size, EVP_sha256(), nullptr);
  LIVEGS_ASSERT(done == 1 && size == 32);
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  text.reserve(64);
  for (unsigned int i = 0; i < size; ++i) {
    text += kDigits[digest[i] >> 4];
    text += kDigits[digest[i] & 15];
  }
  return text;
}

}  // namespace livegs
