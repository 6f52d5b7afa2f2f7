// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace livegs {

// Content codings of HTTP that the server applies to assets (RFC 9110, section 8.4.1; zstd: RFC 8878).
enum class ContentCoding { Identity, Gzip, Zstd };

// "", "gzip" or "zstd".
std::string_view name_of(ContentCoding coding);

// Whether an Accept-Encoding field accepts the coding `name`.
bool accepts_coding(std::string_view accept_encoding, std::string_view name);

// zstd if the field accepts it, else gzip, else Identity.
ContentCoding choose_coding(std::string_view accept_encoding);

// Compresses at a fast level. Any thread.
Result<std::vector<std::byte>> encode_content(std::span<const std::byte> bytes, ContentCoding coding);

}  // namespace livegs
