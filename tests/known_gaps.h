// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <set>
#include <string>

// Figures that miss their bound. tests/known_gaps.csv has the bound and the reached figure of each; the gate
// does not compare them. With LIVEGS_GAPS_OUT set, each figure is appended to that file for
// tests/compare_gaps.

namespace livegs {

// The ids of known_gaps.csv. Fields contain no commas.
inline const std::set<std::string>& gap_ids() {
  static const std::set<std::string> ids = [] {
    std::set<std::string> found;
    std::ifstream file(LIVEGS_TESTS_DIR "/known_gaps.csv");
    std::string line;
    std::getline(file, line);  // header
    while (std::getline(file, line)) found.insert(line.substr(0, line.find(',')));
    return found;
  }();
  return ids;
}

// Reports a figure of a gap. If it is reported several times, the worst value counts. Fails if the id is not
// in the table or the value is not finite.
inline void report_gap(const std::string& id, double value) {
  EXPECT_TRUE(gap_ids().contains(id)) << id << ": not in tests/known_gaps.csv; add a row";
  EXPECT_TRUE(std::isfinite(value)) << id;
  const char* path = std::getenv("LIVEGS_GAPS_OUT");
  if (!path || !*path) return;
  std::FILE* file = std::fopen(path, "a");
  ASSERT_TRUE(file) << path;
  std::fprintf(file, "%s,%.6g\n", id.c_str(), value);  // a single write, because other processes append too
  std::fclose(file);
}

}  // namespace livegs
