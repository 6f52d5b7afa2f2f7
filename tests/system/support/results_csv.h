// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdlib.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

namespace livegs {

// Appends a row to the CSV that the environment names, with the machine's load of the last minute as its last
// column, and the header first where the file is new. Nothing where it names none: results are written when a
// test is run by hand.
inline void add_result(const char* variable, const std::string& header, const std::string& row) {
  const char* path = ::getenv(variable);
  if (!path) return;
  const bool is_new = !std::filesystem::exists(path);
  std::ofstream file(path, std::ios::app);
  if (is_new) file << header << ",load\n";
  double load = 0;
  (void)::getloadavg(&load, 1);
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", load);
  file << row << "," << text << "\n";
}

}  // namespace livegs
