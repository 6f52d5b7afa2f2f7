// SPDX-License-Identifier: Apache-2.0
#include "trust/fingerprint.h"

#include <openssl/bio.h>
#include <openssl/crypto.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <cctype>
#include <memory>
#include <vector>

#include "core/content_hash.h"

namespace livegs {
namespace {

constexpr std::string_view kDigits = "0123456789ABCDEFGHJKMNPQRSTVWXYZ";  // Crockford's base 32
constexpr size_t kGroup = 5, kCodeDigits = 25;

int hexadecimal(char c) { return c >= 'a' ? c - 'a' + 10 : c - '0'; }

// The digits of a code as printed by pairing_code(), without dashes. Empty if the code is invalid.
std::string code_digits(std::string_view code) {
  std::string digits;
  for (char c : code) {
    if (c == '-' || c == ' ') continue;
    c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    if (c == 'O') c = '0';
    if (c == 'I' || c == 'L') c = '1';
    if (kDigits.find(c) == std::string_view::npos) return "";
    digits += c;
  }
  if (digits.size() != kCodeDigits) digits.clear();
  return digits;
}

}  // namespace

Result<std::string> certificate_fingerprint(std::string_view pem) {
  const std::unique_ptr<BIO, decltype(&BIO_free)> text(
      BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())), &BIO_free);
  const std::unique_ptr<X509, decltype(&X509_free)> certificate(
      PEM_read_bio_X509(text.get(), nullptr, nullptr, nullptr), &X509_free);
  unsigned char* der = nullptr;
  const int size = certificate ? i2d_X509(certificate.get(), &der) : -1;
  if (size <= 0) return invalid_data("certificate: is not a PEM certificate");
  const std::vector<unsigned char> bytes(der, der + size);
  OPENSSL_free(der);
  return content_hash(std::as_bytes(std::span(bytes)));
}

std::string pairing_code(std::string_view fingerprint) {
  std::string code;
  uint32_t bits = 0;
  int held = 0;
  size_t digits = 0;
  for (const char c : fingerprint) {
    bits = bits << 4 | static_cast<uint32_t>(hexadecimal(c));
    held += 4;
    if (held < 5) continue;
    held -= 5;
    if (digits > 0 && digits % kGroup == 0) code += '-';
    code += kDigits[bits >> held & 31];
    if (++digits == kCodeDigits) break;
  }
  return code;
}

Result<void> check_pairing_code(std::string_view code) {
  if (!code_digits(code).empty()) return {};
  return invalid_argument(
      "pairing code: must be five groups of five letters and digits; copy it from the output of the "
      "server's start");
}

bool fits_pairing_code(std::string_view fingerprint, std::string_view code) {
  const std::string given = code_digits(code);
  return !given.empty() && equal_in_constant_time(given, code_digits(pairing_code(fingerprint)));
}

bool equal_in_constant_time(std::string_view a, std::string_view b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

}  // namespace livegs
