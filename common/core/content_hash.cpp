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

ContentHasher::ContentHasher() : context_(EVP_MD_CTX_new()) {
  const int done = EVP_DigestInit_ex(static_cast<EVP_MD_CTX*>(context_.get()), EVP_sha256(), nullptr);
  LIVEGS_ASSERT(done == 1);
}

void ContentHasher::Free::operator()(void* context) const {
  EVP_MD_CTX_free(static_cast<EVP_MD_CTX*>(context));
}

void ContentHasher::add(std::span<const std::byte> piece) {
  const int done = EVP_DigestUpdate(static_cast<EVP_MD_CTX*>(context_.get()), piece.data(), piece.size());
  LIVEGS_ASSERT(done == 1);
}

std::string ContentHasher::hash() {
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int size = 0;
  const int done = EVP_DigestFinal_ex(static_cast<EVP_MD_CTX*>(context_.get()), digest, &size);
  LIVEGS_ASSERT(done == 1 && size == 32);
  return hexadecimal(std::as_bytes(std::span(digest, size)));
}

std::string content_hash(std::span<const std::byte> bytes) {
  ContentHasher hasher;
  hasher.add(bytes);
  return hasher.hash();
}

}  // namespace livegs
