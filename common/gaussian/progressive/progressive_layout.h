// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "gaussian/progressive/column_codec.h"

// Constants of proto/asset_format.md shared by encoder and decoder.

namespace livegs::progressive_layout {

inline constexpr std::array<uint8_t, 8> kMagic{'L', 'V', 'G', 'A', 'S', 'T', 1, '\n'};
inline constexpr std::array<uint8_t, 8> kEditMagic{'L', 'V', 'G', 'E', 'D', 'T', 1, '\n'};
inline constexpr size_t kHeadBytes = 16, kEditHeadBytes = 20, kBlockHeadBytes = 8;
inline constexpr uint8_t kAntialiased = 1;

// Kernels or runs per block. The first block is small, so that drawing can start early. Each next one is
// twice as large, up to the maximum.
inline constexpr size_t kFirstBlockKernels = 1024, kMaxBlockKernels = 32768;

// Index, position, log-scale, rotation, opacity, colour.
inline constexpr size_t kFloatColumns = 14, kKernelColumns = 1 + kFloatColumns;
// Of a run of kernels that an edit keeps: step in the base, skipped kernels of the asset, length.
inline constexpr size_t kRunColumns = 3;
inline constexpr size_t kMaxBlockRatio = 1024;
inline constexpr uint64_t kMaxDecodedBytes = uint64_t{4} << 30;

inline constexpr size_t harmonic_columns(int degree) {
  return 3 * static_cast<size_t>((degree + 1) * (degree + 1) - 1);
}
inline constexpr size_t max_raw_bytes(size_t columns, size_t kernels) {
  return columns * max_column_bytes(kernels);
}
inline constexpr size_t min_payload_bytes(size_t columns, size_t kernels) {
  return (columns * kernels * sizeof(float) + kMaxBlockRatio - 1) / kMaxBlockRatio;
}
// Upper bound of a zstd frame, bytes. zstd stores incompressible data with a small overhead.
inline constexpr size_t max_payload_bytes(size_t columns, size_t kernels) {
  return max_raw_bytes(columns, kernels) + max_raw_bytes(columns, kernels) / 16 + 8192;
}

}  // namespace livegs::progressive_layout
