// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace livegs {

// Output files of this process, so that a program can name them when it ends. Any thread.

// Adds a file that was written for the user. A file that is written again counts once.
void note_written(const std::filesystem::path& path);

// These files, as far as they still exist.
std::vector<std::filesystem::path> written_files();

// One line per file that still exists, "written: PATH"; more than kMaxNamedFiles of a folder with the same
// ending become one line with their number. In the order of the first of each. Empty if there are none.
inline constexpr size_t kMaxNamedFiles = 4;
std::string written_files_text();

}  // namespace livegs
