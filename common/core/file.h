// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "core/result.h"

namespace livegs {

// Largest file that is read whole, bytes. 4 GiB holds 17 million full kernels.
inline constexpr uint64_t kMaxFileBytes = uint64_t{4} << 30;

// Reads a regular file whole. The error names the path and the problem (absent, a folder, not readable, over
// `max_bytes`).
Result<std::vector<std::byte>> read_file(const std::filesystem::path& path,
                                         uint64_t max_bytes = kMaxFileBytes);
Result<std::string> read_text_file(const std::filesystem::path& path, uint64_t max_bytes = 64 << 20);

// The error of a system call on a path: "PATH: PROBLEM: REASON; REMEDY", with the remedy for the reason.
// Internal if another machine or a later time may succeed (no space, I/O error), PermissionDenied otherwise.
// `reason` is errno by default.
Error file_error(const std::filesystem::path& path, std::string_view problem);
Error file_error(const std::filesystem::path& path, std::string_view problem, std::error_code reason);

// Called before each step that changes the disk, with the name of the step ("write", "sync", "rename", …).
// Tests end the process in it.
using WriteStep = std::function<void(const char* step)>;

// Writes a temporary file next to the target, syncs it, renames it over the target and syncs the folder. A
// reader sees the old file or the new one, never a part, also after a power failure.
Result<void> write_file_atomically(const std::filesystem::path& path, std::span<const std::byte> bytes,
                                   const WriteStep& before = {});
Result<void> write_file_atomically(const std::filesystem::path& path, std::string_view text,
                                   const WriteStep& before = {});

}  // namespace livegs
