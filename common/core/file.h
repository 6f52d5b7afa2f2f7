// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace livegs {

// The largest file that is ever read whole: 4 GiB holds 17 million full kernels.
inline constexpr uint64_t kMaxFileBytes = uint64_t{4} << 30;

// A regular file, whole. The error names the path and what is wrong with it (absent, a folder, not readable,
// over `max_bytes`).
Result<std::vector<std::byte>> read_file(const std::filesystem::path& path,
                                         uint64_t max_bytes = kMaxFileBytes);
Result<std::string> read_text_file(const std::filesystem::path& path, uint64_t max_bytes = 64 << 20);

// Writes beside the target, syncs, then renames over it: a reader sees the old file or the new one, never
// half.
Result<void> write_file_atomically(const std::filesystem::path& path, std::span<const std::byte> bytes);
Result<void> write_file_atomically(const std::filesystem::path& path, std::string_view text);

}  // namespace livegs
