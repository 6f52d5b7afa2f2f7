// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gaussian/asset/bytes.h"

namespace livegs {

// A column of 32-bit words, the bits of floats or small whole numbers, written so that zstd finds what
// repeats in it: proto/asset_format.md, "Columns". Lossless. The planes are told apart, since each compresses
// best by itself.
struct ColumnBytes {
  std::vector<std::byte> bytes;
  std::vector<size_t> ends;  // of the planes, ascending; the last is bytes.size()
};
// Whichever of the three ways has the least entropy a byte. At least one word.
ColumnBytes encode_column(std::span<const uint32_t> words);

// As many words as `words` holds, from the beginning of `bytes`, which is moved past them. False for bytes
// that are no such column.
bool decode_column(Bytes& bytes, std::span<uint32_t> words);

// What a column of `count` words takes at most.
inline constexpr size_t max_column_bytes(size_t count) { return 4 * count + 5; }

}  // namespace livegs
