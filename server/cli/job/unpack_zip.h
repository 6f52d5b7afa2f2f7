// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "core/result.h"

namespace livegs {

// Largest sum of the unpacked files, bytes.
inline constexpr uint64_t kMaxUnpackedBytes = uint64_t{64} << 30;

// Unpacks a .zip into `folder`. Names that lead out of the folder are refused; __MACOSX and .DS_Store, which
// macOS adds, are skipped. Returns the folder of the contents: the only top folder of the archive, or
// `folder`.
Result<std::filesystem::path> unpack_zip(const std::filesystem::path& zip,
                                         const std::filesystem::path& folder);

}  // namespace livegs
