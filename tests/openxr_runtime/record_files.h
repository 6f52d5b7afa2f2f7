// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace livegs {

// Reads the files of Record. rows() returns the rows of a table without its header; text() returns the text
// of a file, empty if the file is missing.
inline std::vector<std::vector<std::string>> rows(const std::filesystem::path& csv) {
  std::vector<std::vector<std::string>> read;
  std::ifstream file(csv);
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::vector<std::string>& row = read.emplace_back();
    for (std::string word; std::getline(words, word, ',');) row.push_back(word);
  }
  if (!read.empty()) read.erase(read.begin());
  return read;
}

inline std::string text(const std::filesystem::path& path) {
  std::ostringstream read;
  read << std::ifstream(path).rdbuf();
  return read.str();
}

}  // namespace livegs
