// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace livegs {

// Two lower-case digits a byte.
std::string hexadecimal(std::span<const std::byte> bytes);

// SHA-256 of the bytes, as 64 lower-case hexadecimal digits: the name by which assets are cached and
// compared.
std::string content_hash(std::span<const std::byte> bytes);

}  // namespace livegs
