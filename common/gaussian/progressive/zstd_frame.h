// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "gaussian/asset/bytes.h"

namespace livegs {

// The zstd frame at the beginning of a block (proto/asset_format.md). zstd_frame.cpp reads any frame;
// zstd_frame_stored.cpp, for targets without libzstd, only frames whose blocks are stored (stored_blocks.h).
// Both accept any bytes.

// Size of the frame in bytes, at most that of the payload; nothing if the payload does not begin with a
// frame.
std::optional<size_t> zstd_frame_size(Bytes payload);

// Writes the content of a frame, as found by zstd_frame_size(), to the front of `out`, and returns its size;
// nothing if it is damaged or does not fit.
std::optional<size_t> zstd_frame_content(Bytes frame, std::span<std::byte> out);

}  // namespace livegs
