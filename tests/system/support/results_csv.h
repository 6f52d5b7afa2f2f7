// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdlib.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

namespace livegs {

// Appends a row to the CSV file that the environment variable names. The last column is the load average of
// the last minute; a new file gets the header first. Does nothing if the variable is not set: results are
// written when a test is run by hand.
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
