// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

namespace livegs {

// Names of temporary paths in messages: a job writes to a temporary folder what belongs to an address. Any
// thread.

// Messages name a file or folder, and what is below it, as `shown`.
void show_path_as(const std::filesystem::path& path, const std::string& shown);
// The text with these paths replaced.
std::string with_shown_paths(std::string text);

}  // namespace livegs
