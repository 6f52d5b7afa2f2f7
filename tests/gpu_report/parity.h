// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace livegs::gpu_report {

struct ParityRow {
  std::string suite, test, verdict;  // passed, failed or skipped
  double ms = 0;
  std::string message;  // the first failure, or the reason of the skip; one line
};

struct Parity {
  std::vector<ParityRow> rows;
  bool validated = false;  // ran with the validation layer
  int count(const std::string& verdict) const {
    return static_cast<int>(std::count_if(rows.begin(), rows.end(),
                                          [&](const ParityRow& row) { return row.verdict == verdict; }));
  }
  bool passed() const { return count("failed") == 0 && count("passed") > 0; }
};

// The tests of all passes. `filter` as --gtest_filter; empty: all. Progress goes to standard error. Call
// once.
Parity run_parity(const std::string& filter, bool validation);

}  // namespace livegs::gpu_report
