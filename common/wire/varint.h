// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "wire/little_endian.h"

// Integers of seven bits per byte, low bits first. See proto/frame_format.md, "Frame".

namespace livegs {

inline void write_varint(ByteWriter& out, uint64_t value) {
  for (; value >= 0x80; value >>= 7) out.write(static_cast<uint8_t>(value | 0x80));
  out.write(static_cast<uint8_t>(value));
}

// Empty if the input is truncated or longer than 64 bits.
inline std::optional<uint64_t> read_varint(ByteReader& in) {
  uint64_t value = 0;
  for (int shift = 0; shift < 64; shift += 7) {
    const uint8_t byte = in.read<uint8_t>();
    if (in.failed() || (shift == 63 && byte > 1)) return std::nullopt;
    value |= static_cast<uint64_t>(byte & 0x7F) << shift;
    if (byte < 0x80) return value;
  }
  return std::nullopt;
}

// Maps signed integers to unsigned ones that are small if the value is near zero.
inline uint64_t zigzag(int64_t value) {
  return static_cast<uint64_t>(value) << 1 ^ static_cast<uint64_t>(value >> 63);
}
inline int64_t unzigzag(uint64_t value) { return static_cast<int64_t>(value >> 1 ^ (~(value & 1) + 1)); }

}  // namespace livegs
