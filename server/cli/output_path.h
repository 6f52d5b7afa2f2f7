// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <initializer_list>

#include "core/result.h"

namespace livegs {

// Checks that a command writes the format that the ending of an output file names. The error lists the
// endings.
Result<void> check_output_file(const std::filesystem::path& path, std::initializer_list<const char*> endings);

// Checks before long work that an output folder can be made: it does not have the name of a file (an ending
// of a format, unless the folder exists), and what exists of its path is a folder that can be written. An
// empty path passes.
Result<void> check_output_folder(const std::filesystem::path& path);

}  // namespace livegs
