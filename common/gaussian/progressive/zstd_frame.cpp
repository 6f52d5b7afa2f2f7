// SPDX-License-Identifier: Apache-2.0
#include "gaussian/progressive/zstd_frame.h"

#include <zstd.h>

namespace livegs {

std::optional<size_t> zstd_frame_size(Bytes payload) {
  const size_t size = ZSTD_findFrameCompressedSize(payload.data(), payload.size());
  if (ZSTD_isError(size)) return std::nullopt;
  return size;
}

std::optional<size_t> zstd_frame_content(Bytes frame, std::span<std::byte> out) {
  const size_t size = ZSTD_decompress(out.data(), out.size(), frame.data(), frame.size());
  if (ZSTD_isError(size)) return std::nullopt;
  return size;
}

}  // namespace livegs
