// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "core/sanitizers.h"
#include "system/support/program.h"

// Runs of the tool LIVEGS_TOOL on files of users, with little memory.

namespace livegs {

// Sanitizers reserve terabytes.
inline constexpr bool kLimited = !LIVEGS_ADDRESS_SANITIZER && !LIVEGS_THREAD_SANITIZER;

// What a run of the tool printed.
struct ToolOutcome {
  int code = -1;
  std::string out, err;

  // The rest of the line that starts with this word; empty if none does.
  std::string value(const std::string& word) const {
    std::istringstream lines(out);
    for (std::string line; std::getline(lines, line);) {
      if (!line.starts_with(word + " ")) continue;
      const size_t at = line.find_first_not_of(' ', word.size());
      return at == line.npos ? "" : line.substr(at);
    }
    return "";
  }
  double number(const std::string& word) const { return std::strtod(value(word).c_str(), nullptr); }
};

// Runs the tool under 4 GB of address space. A shell that cannot set the limit ends with an error.
inline ToolOutcome run_tool(std::vector<std::string> words) {
  std::vector<std::string> all = {
      "/bin/sh", "-c",        std::string(kLimited ? "ulimit -v 4194304 && " : "") + "exec \"$@\"",
      "sh",      LIVEGS_TOOL, "--threads",
      "2"};
  all.insert(all.end(), words.begin(), words.end());
  Program program(all);
  ToolOutcome outcome;
  outcome.code = program.wait();
  outcome.out = program.out();
  outcome.err = program.err();
  return outcome;
}

// The number in `column` of the last row of this object in a bodies.csv of `livegs simulate`; NaN: no row.
inline double last_value(const std::filesystem::path& bodies_csv, const std::string& object,
                         const std::string& column) {
  const auto cells_of = [](const std::string& line) {
    std::vector<std::string> cells;
    std::istringstream values(line);
    for (std::string cell; std::getline(values, cell, ',');) cells.push_back(cell);
    return cells;
  };
  std::ifstream file(bodies_csv);
  std::string line;
  std::getline(file, line);
  const std::vector<std::string> names = cells_of(line);
  double last = std::nan("");
  while (std::getline(file, line)) {
    const std::vector<std::string> cells = cells_of(line);
    for (size_t i = 0; cells.size() == names.size() && cells[2] == object && i < names.size(); ++i) {
      if (names[i] == column) last = std::strtod(cells[i].c_str(), nullptr);
    }
  }
  return last;
}

// The ratio that a warning of masses names ("... is 20000 times the ..."); 0: none.
inline double named_mass_ratio(const std::string& text) {
  std::smatch found;
  static const std::regex kRatio("physics\\.mass_kg: \\S+ kg is ([0-9]+) times the \\S+ kg of ");
  return std::regex_search(text, found, kRatio) ? std::strtod(found[1].str().c_str(), nullptr) : 0;
}

// Smallest and largest y of the vertices of an .obj; a text without vertices gives zeros.
inline std::pair<double, double> y_range_of_obj(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::pair<double, double> range{0, 0};
  bool first = true;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string kind;
    double x = 0, y = 0;
    if (!(words >> kind >> x >> y) || kind != "v") continue;
    range = first ? std::pair(y, y) : std::pair(std::min(range.first, y), std::max(range.second, y));
    first = false;
  }
  return range;
}

}  // namespace livegs
