// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace livegs {

static_assert(std::endian::native == std::endian::little,
              "file formats are read in memory layout (little-endian)");

using Bytes = std::span<const std::byte>;

// Precondition: `bytes` contains sizeof(T) bytes from `offset`.
template <class T>
T load(Bytes bytes, size_t offset) {
  static_assert(std::is_trivially_copyable_v<T>);
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

template <class T>
void append(std::vector<std::byte>& bytes, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  const auto* first = reinterpret_cast<const std::byte*>(&value);
  bytes.insert(bytes.end(), first, first + sizeof(T));
}

inline unsigned byte_at(Bytes bytes, size_t offset) { return std::to_integer<unsigned>(bytes[offset]); }

}  // namespace livegs
