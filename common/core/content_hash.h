// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace livegs {

// Lower-case hexadecimal digits, two per byte.
std::string hexadecimal(std::span<const std::byte> bytes);

// SHA-256 of the bytes as 64 lower-case hexadecimal digits. Assets are cached and compared by this name.
std::string content_hash(std::span<const std::byte> bytes);

}  // namespace livegs
