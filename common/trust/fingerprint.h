// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "core/result.h"

namespace livegs {

// SHA-256 of the DER form of the first certificate in a PEM text, 64 hexadecimal digits. InvalidData if there
// is not a certificate.
Result<std::string> certificate_fingerprint(std::string_view pem);

// The pairing code, which the user copies from the server to a client to authenticate the server: the first
// 125 bits of the fingerprint in Crockford's base 32, five groups of five. It is not a secret. A man in the
// middle would need a certificate with the same 125 bits, 2^125 trials. A six-digit code, or any text short
// enough for exhaustive search, could be matched while the user types.
std::string pairing_code(std::string_view fingerprint);

// Case, spaces and dashes are ignored; O is read as 0, I and L as 1. InvalidArgument if the code is
// malformed.
Result<void> check_pairing_code(std::string_view code);
bool fits_pairing_code(std::string_view fingerprint, std::string_view code);

// Whether two texts are equal. The time does not depend on the position of the first difference.
bool equal_in_constant_time(std::string_view a, std::string_view b);

}  // namespace livegs
