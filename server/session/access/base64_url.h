// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace livegs {

// base64url without padding (RFC 4648 section 5).
std::string base64_url(std::span<const unsigned char> bytes);
// Empty for any other character or an impossible length. Unused bits of the last character are ignored.
std::optional<std::string> from_base64_url(std::string_view text);

}  // namespace livegs
