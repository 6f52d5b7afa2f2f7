// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/values/csv_lines.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <vector>

#include "core/file.h"

namespace livegs {

Result<void> read_csv_lines(
    const std::filesystem::path& path, const CsvLayout& layout,
    const std::function<Result<void>(size_t line, std::span<const double> numbers)>& take) {
  const auto text = read_text_file(path, layout.max_bytes);
  if (!text) return text.error();
  const std::string name = path.filename().string();
  std::vector<double> numbers;  // one per column of the header
  size_t line_number = 0;
  for (size_t begin = 0; begin < text->size();) {
    const size_t end = std::min(text->find('\n', begin), text->size());
    std::string_view line(text->data() + begin, end - begin);
    begin = end + 1;
    ++line_number;
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.remove_suffix(1);
    if (line.empty()) continue;
    if (numbers.empty()) {
      if (line.starts_with("\xef\xbb\xbf")) line.remove_prefix(3);  // byte order mark
      std::string header(line);
      std::erase(header, ' ');
      if (header != layout.header && header != layout.longer_header) {
        return invalid_data(name + ": line 1 must be the header " + layout.header + " or " +
                            layout.longer_header);
      }
      numbers.resize(1 + static_cast<size_t>(std::count(header.begin(), header.end(), ',')));
      continue;
    }
    const char* at = line.data();
    const char* const stop = line.data() + line.size();
    for (size_t column = 0; column < numbers.size(); ++column) {
      double& number = numbers[column];
      while (at < stop && *at == ' ') ++at;
      const auto [rest, error] = std::from_chars(at, stop, number);
      const bool last = column + 1 == numbers.size();
      if (error != std::errc() || !std::isfinite(number) || std::abs(number) > layout.max_magnitude ||
          (last ? rest != stop : rest == stop || *rest != ',')) {
        return invalid_data(name + ": line " + std::to_string(line_number) + ", column " +
                            std::to_string(column + 1) + ": expected " + std::to_string(numbers.size()) +
                            " numbers");
      }
      at = last ? rest : rest + 1;
    }
    if (auto taken = take(line_number, numbers); !taken) return taken;
  }
  return {};
}

}  // namespace livegs
