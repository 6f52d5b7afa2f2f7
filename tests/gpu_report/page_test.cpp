// SPDX-License-Identifier: GPL-3.0-or-later
#include "gpu_report/page.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

namespace livegs::gpu_report {
namespace {

// One million kernels for both eyes of a headset, all goals met with a margin. Bytes are such that skin and
// sort reach 80 % of 1000 GB/s.
Report gpu_report() {
  Report report;
  report.device.name = "Made GPU, 8 GB";
  report.device.driver = "made 1.0";
  report.device.all = {{"name", "Made GPU, 8 GB"}, {"driver", "made \"1.0\""}};
  report.copy = CopyBandwidth{1e12, 1e9};
  report.parity = Parity{{{"Sort", "SortsKeys", "passed", 5, {}}}, true};
  TimesRow row;
  row.kernels = 1'000'000;
  row.eyes = 2;
  row.width = 2064;
  row.height = 2208;
  row.device = {0.1, 0.3, 0.2, 2.5, 0.05};
  row.bytes = {.skin = 0.08e9, .project = 0.2e9, .sort = 0.16e9, .draw = 0.1e9, .resolve = 0.05e9};
  row.memory_bytes_a_kernel = 244;
  report.times = {row};
  return report;
}

// The verdict in the line of a goal that begins with `goal`.
std::string verdict(const Report& report, const std::string& goal) {
  std::istringstream lines(page(report));
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("| " + goal, 0) == 0) {
      const size_t end = line.rfind(" |"), begin = line.rfind("| ", end - 1);
      return line.substr(begin + 2, end - begin - 2);
    }
  }
  return "no such goal";
}

constexpr const char *kPassesGoal = "skin, project and sort", *kDrawGoal = "draw and resolve of the same",
                     *kSkinGoal = "skin: ", *kSortGoal = "sort: ", *kMemoryGoal = "device memory";

TEST(GpuReportPage, StatesDeviceParityAndShares) {
  const std::string text = page(gpu_report());
  EXPECT_EQ(text.rfind("# GPU report: Made GPU, 8 GB\n", 0), 0u) << text;
  EXPECT_NE(text.find("**Passed.** 1 tests passed, 0 failed, 0 skipped in 0 s, with the validation layer"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("| 0.100 (80 %) | 0.300 (67 %) | 0.200 (80 %) | 2.500 (4 %) |"), std::string::npos)
      << text;
}

TEST(GpuReportPage, GoalsAreMet) {
  for (const char* goal : {kPassesGoal, kDrawGoal, kSkinGoal, kSortGoal, kMemoryGoal})
    EXPECT_EQ(verdict(gpu_report(), goal), "met") << goal;
}

TEST(GpuReportPage, EachGoalCanBeMissed) {
  Report report = gpu_report();
  TimesRow& row = report.times[0];
  row.device.project_ms = 1.8;
  EXPECT_EQ(verdict(report, kPassesGoal), "**missed**");
  EXPECT_EQ(verdict(report, kDrawGoal), "met");
  row.device.draw_ms = 3.01;
  EXPECT_EQ(verdict(report, kDrawGoal), "**missed**");
  row.device.skin_ms = 0.14;  // 57 %
  EXPECT_EQ(verdict(report, kSkinGoal), "**missed**");
  EXPECT_EQ(verdict(report, kSortGoal), "met");
  row.device.sort_ms = 0.28;
  EXPECT_EQ(verdict(report, kSortGoal), "**missed**");
  row.memory_bytes_a_kernel = 256.5;
  EXPECT_EQ(verdict(report, kMemoryGoal), "**missed**");
}

TEST(GpuReportPage, GoalsWithoutAFigureAreNotMeasured) {
  Report report = gpu_report();
  report.times[0].width = 640;
  EXPECT_EQ(verdict(report, kDrawGoal), "not measured");
  EXPECT_EQ(verdict(report, kPassesGoal), "met");
  report.copy.reset();
  EXPECT_EQ(verdict(report, kSkinGoal), "not measured");
  report.times[0].device = {};  // a device without a clock
  EXPECT_EQ(verdict(report, kPassesGoal), "not measured");
  report.times[0].eyes = 1;
  EXPECT_EQ(verdict(report, kMemoryGoal), "not measured");
}

TEST(GpuReportPage, SoftwareDeviceHasCountsOnly) {
  Report report = gpu_report();
  report.device.software = true;
  const std::string text = page(report);
  EXPECT_NE(text.find("## Counts"), std::string::npos);
  EXPECT_EQ(text.find("## Times"), std::string::npos);
  EXPECT_EQ(text.find("## Goals"), std::string::npos);
}

TEST(GpuReportPage, NamesFailedTests) {
  Report report = gpu_report();
  report.parity->rows.push_back({"Skin", "MatchesTheTwin", "failed", 1, "off by 3"});
  EXPECT_FALSE(report.parity->passed());
  const std::string text = page(report);
  EXPECT_NE(text.find("**Failed.** 1 tests passed, 1 failed"), std::string::npos) << text;
  EXPECT_NE(text.find("- `Skin.MatchesTheTwin`: off by 3\n"), std::string::npos) << text;
  EXPECT_FALSE((Parity{{{"Skin", "A", "skipped", 0, {}}}, true}).passed());  // nothing ran
}

TEST(GpuReportPage, CsvRowsHaveAsManyFieldsAsTheHeader) {
  std::istringstream lines(times_csv(gpu_report()));
  std::string device, header, row;
  std::getline(lines, device);
  std::getline(lines, header);
  std::getline(lines, row);
  EXPECT_EQ(device, "# Made GPU, 8 GB");
  EXPECT_EQ(std::count(header.begin(), header.end(), ','), std::count(row.begin(), row.end(), ','));
  EXPECT_EQ(header.rfind("kernels,eyes,width,height,method,blend_bits,frames,", 0), 0u);
  EXPECT_EQ(device_csv(gpu_report().device),
            "property,value\nname,\"Made GPU, 8 GB\"\ndriver,\"made \"\"1.0\"\"\"\n");
}

TEST(PassBytes, FollowTheLayouts) {
  const PassBytes bytes =
      pass_bytes({.kernels = 2048, .cells = 10, .nodes = 20, .eyes = 2, .pixels = 100, .sh_row_words = 23});
  EXPECT_EQ(bytes.skin, 2048.0 * (40 + 52) + 10 * 32 + 20 * 64);
  EXPECT_EQ(bytes.project, 2048.0 * (52 + 16 + 92 + 2 * 36 + 4));
  EXPECT_EQ(bytes.sort, 2048.0 * (8 * 20 - 4) + 8 * 4 * 64);
  EXPECT_EQ(bytes.draw, 2048.0 * (4 + 2 * 36) + 2 * 100 * 8);
  EXPECT_EQ(bytes.resolve, 2.0 * 100 * (8 + 4));
}

}  // namespace
}  // namespace livegs::gpu_report
