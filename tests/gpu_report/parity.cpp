// SPDX-License-Identifier: GPL-3.0-or-later
#include "gpu_report/parity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "common/compute/shared_vulkan.h"

namespace livegs::gpu_report {
namespace {

std::string one_line(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

// Keeps a row per test and prints progress, in place of GoogleTest's own printer.
class Listener final : public ::testing::EmptyTestEventListener {
 public:
  explicit Listener(std::vector<ParityRow>& rows) : rows_(rows) {}

  void OnTestSuiteStart(const ::testing::TestSuite& suite) override {
    std::fprintf(stderr, "gpu-report: parity: %s, %d tests\n", suite.name(), suite.test_to_run_count());
  }
  void OnTestPartResult(const ::testing::TestPartResult& part) override {
    if (part.failed()) std::fprintf(stderr, "gpu-report: failure: %s\n", one_line(part.message()).c_str());
  }
  void OnTestEnd(const ::testing::TestInfo& test) override {
    const ::testing::TestResult& result = *test.result();
    ParityRow row{test.test_suite_name(),
                  test.name(),
                  result.Skipped()  ? "skipped"
                  : result.Passed() ? "passed"
                                    : "failed",
                  static_cast<double>(result.elapsed_time()),
                  {}};
    add_message(row, result);
    rows_.push_back(row);
    if (row.verdict == "failed")
      std::fprintf(stderr, "gpu-report: parity: %s.%s failed\n", row.suite.c_str(), row.test.c_str());
  }
  // Failures outside of tests: messages of the validation layer after the last test.
  void OnTestProgramEnd(const ::testing::UnitTest& program) override {
    const ::testing::TestResult& result = program.ad_hoc_test_result();
    if (!result.Failed()) return;
    ParityRow row{"Device", "EndsWithoutMessages", "failed", 0, {}};
    add_message(row, result);
    rows_.push_back(row);
  }

 private:
  static void add_message(ParityRow& row, const ::testing::TestResult& result) {
    for (int i = 0; i < result.total_part_count() && row.message.empty(); ++i) {
      const ::testing::TestPartResult& part = result.GetTestPartResult(i);
      if (part.failed() || part.skipped()) row.message = one_line(part.message());
    }
  }

  std::vector<ParityRow>& rows_;
};

}  // namespace

Parity run_parity(const std::string& filter, bool validation) {
  Parity parity;
  parity.validated = validation;
  test_devices() = {.validation = validation, .pipeline_cache_folder = user_pipeline_cache_folder()};
  int argc = 1;
  char name[] = "livegs-gpu-report", *argv[] = {name, nullptr};
  ::testing::InitGoogleTest(&argc, argv);
  if (!filter.empty()) GTEST_FLAG_SET(filter, filter);
  ::testing::TestEventListeners& listeners = ::testing::UnitTest::GetInstance()->listeners();
  delete listeners.Release(listeners.default_result_printer());
  listeners.Append(new Listener(parity.rows));  // GoogleTest owns it
  if (RUN_ALL_TESTS() != 0 && parity.count("failed") == 0)
    parity.rows.push_back({"Tests", "Run", "failed", 0, "GoogleTest reports a failure outside of the tests"});
  return parity;
}

}  // namespace livegs::gpu_report
