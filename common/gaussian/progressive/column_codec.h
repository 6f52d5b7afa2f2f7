// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gaussian/asset/bytes.h"

namespace livegs {

// Codec of a column of 32-bit words (float bits or small integers), arranged so that zstd finds repetitions:
// proto/asset_format.md, "Columns". Lossless. The ends of the planes are returned, because each plane
// compresses best separately.
struct ColumnBytes {
  std::vector<std::byte> bytes;
  std::vector<size_t> ends;  // of the planes, ascending; the last is bytes.size()
};
// Chooses the one of the three modes with the least byte entropy. Precondition: at least one word.
ColumnBytes encode_column(std::span<const uint32_t> words);

// Decodes words.size() words from the beginning of `bytes` and advances `bytes` past them. False for bytes
// that are not a valid column.
bool decode_column(Bytes& bytes, std::span<uint32_t> words);

// Maximum encoded size of a column of `count` words, bytes.
inline constexpr size_t max_column_bytes(size_t count) { return 4 * count + 5; }

}  // namespace livegs
