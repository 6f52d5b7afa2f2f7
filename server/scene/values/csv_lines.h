// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "core/result.h"

namespace livegs {

struct CsvLayout {
  // The two allowed headers, without spaces: "x,y,z". The number of names is the number of columns.
  const char* header;
  const char* longer_header;
  double max_magnitude;  // limit of each number; infinity: any finite number
  uint64_t max_bytes;    // limit of the file size
};

// Calls `take` for each row of numbers, in order; line 1 is the header. Empty lines are skipped. Errors name
// the file, the line and the column. An error from `take` ends the reading and is returned unchanged.
Result<void> read_csv_lines(
    const std::filesystem::path& path, const CsvLayout& layout,
    const std::function<Result<void>(size_t line, std::span<const double> numbers)>& take);

}  // namespace livegs
