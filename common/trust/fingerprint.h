// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "core/result.h"

namespace livegs {

// SHA-256 of a certificate (the first of a PEM text) in DER, 64 hexadecimal digits. InvalidData when it is
// none.
Result<std::string> certificate_fingerprint(std::string_view pem);

// What a person carries from the server to a client so that the client knows the server: the first 125 bits
// of the fingerprint in Crockford's base 32, five groups of five. It is no secret. Somebody in between who
// knows it would have to make a certificate that begins like that, 2^125 trials; a code of six digits, or any
// text short enough to be tried through, could be matched while the person types.
std::string pairing_code(std::string_view fingerprint);

// Case, spaces and dashes are as one likes, O is 0, I and L are 1. InvalidArgument when it is no code.
Result<void> check_pairing_code(std::string_view code);
bool fits_pairing_code(std::string_view fingerprint, std::string_view code);

// Whether two texts are equal, in a time that tells nothing of where they differ.
bool equal_in_constant_time(std::string_view a, std::string_view b);

}  // namespace livegs
