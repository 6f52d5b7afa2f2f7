// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

// Constants of proto/recording_format.md shared by writer and reader.

namespace livegs::recording_layout {

inline constexpr std::array<uint8_t, 8> kMagic{'L', 'V', 'G', 'R', 'E', 'C', 1, '\n'};
inline constexpr std::array<uint8_t, 8> kIndexMagic{'L', 'V', 'G', 'I', 'N', 'D', 'E', 'X'};
inline constexpr size_t kTrailerBytes = 16;

enum class ChunkKind : uint8_t {
  Start = 1,
  Object = 2,
  Objects = 3,
  Tick = 4,
  Asset = 5,
  Index = 6,
  File = 7
};
inline constexpr size_t kChunkHeadBytes = 9;
inline constexpr size_t kMaxPayloadBytes = (64u << 20) + (64u << 10);
inline constexpr size_t kAssetPieceBytes = 1u << 20;  // pieces of assets and of files
inline constexpr size_t kMaxFileNameBytes = 4096;

// Ticks from one key tick to the next: the maximum that a seek decodes.
inline constexpr uint64_t kKeyInterval = 128;

}  // namespace livegs::recording_layout
