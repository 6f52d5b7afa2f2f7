// SPDX-License-Identifier: Apache-2.0
// From a controller that moves to a picture that has changed, through the simulated runtime and 4 ms of network each way.
#include <algorithm>
#include <cmath>

#include "system/headset_session.h"
#include "system/results_csv.h"

namespace livegs {
namespace {

constexpr int kJumps = 40;
// 95 of 100 on two cores that draw with the CPU: 43 found. Other programs that take a share of the same cores show in pictures
// that come less often than the display's 11.1 ms: at 13.8 it was 59, and 63 once.
constexpr double kBarP95_ms = 50, kUndisturbed_ms = 13, kDisturbedP95_ms = 86;

double at(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<size_t>(std::lround(share * static_cast<double>(sorted.size() - 1)))];
}

// Drawn by the CPU, since a device in software takes ten times as long for a picture: a hand that holds a box jumps, and
// the first picture that has changed is looked for. Run alone. LIVEGS_LATENCY_CSV names a file that gets a row.
TEST_F(HeadsetSession, AHandIsSeenSoon) {
  std::string timeline = R"(0 pose head 0 1.6 0 1 0 0 0
0 pose right 0 1.6 -1 1 0 0 0
0.5 input right.squeeze 1
)";
  std::vector<double> jumps_s;
  for (int i = 0; i < kJumps; ++i) {
    const double at_s = 1.5 + 0.5037 * i;  // at no fixed phase of the display or of the server
    char line[200];
    std::snprintf(line, sizeof line, "%.5f pose right 0 %.3f -1 1 0 0 0\n%.5f pose right 0 %.3f -1 1 0 0 0\n", at_s - 1e-5,
                  i % 2 ? 1.7 : 1.6, at_s, i % 2 ? 1.6 : 1.7);
    timeline += line;
    jumps_s.push_back(at_s);
  }
  timeline += std::to_string(jumps_s.back() + 0.6) + " do exit\n";
  const auto done = run(floating({{"held", {0, 0, 0}}}), timeline,
                        {.eye_size = "64x72", .renderer = RendererChoice::Cpu, .network_delay_ms = 4, .marks = false, .validates = false});
  ASSERT_TRUE(done) << done.error().message;
  expect_no_complaints();

  // The box has come to rest before the next jump: its picture has the same hash again and again.
  std::vector<double> seen_ms, submitted_ms, intervals_ms;
  const auto frames = rows(folder_ / "frames.csv");
  double last_s = 0;
  for (const auto& row : frames) {
    if (row.size() < 6 || row[4] != "0") continue;
    if (last_s > 0) intervals_ms.push_back(1e3 * (std::stod(row[2]) - last_s));
    last_s = std::stod(row[2]);
  }
  for (const double jump_s : jumps_s) {
    std::string before;
    for (const auto& row : frames) {
      if (row.size() < 6 || row[4] != "0") continue;
      if (std::stod(row[2]) < jump_s) {
        before = row[5];
      } else if (row[5] != before) {
        submitted_ms.push_back(1e3 * (std::stod(row[2]) - jump_s));
        seen_ms.push_back(1e3 * (std::max(std::stod(row[2]), std::stod(row[3])) - jump_s));
        break;
      }
    }
  }
  ASSERT_EQ(seen_ms.size(), jumps_s.size());
  for (auto* values : {&seen_ms, &submitted_ms, &intervals_ms}) std::sort(values->begin(), values->end());
  std::printf("sample to picture seen p50 %.1f, p95 %.1f ms\n", done->hand_to_picture_ms_p50, done->hand_to_picture_ms_p95);
  std::printf("hand to picture: submitted p50 %.1f, p95 %.1f ms; seen p50 %.1f, p95 %.1f ms; drawing p50 %.1f, p95 %.1f ms, a picture each "
              "p50 %.1f, p95 %.1f ms\n",
              at(submitted_ms, 0.5), at(submitted_ms, 0.95), at(seen_ms, 0.5), at(seen_ms, 0.95), done->draw_ms_p50, done->draw_ms_p95,
              at(intervals_ms, 0.5), at(intervals_ms, 0.95));
  char row[300];
  std::snprintf(row, sizeof row, "%d,4,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f,50", kJumps, at(seen_ms, 0.5), at(seen_ms, 0.95),
                at(submitted_ms, 0.5), at(submitted_ms, 0.95), done->hand_to_picture_ms_p50, done->hand_to_picture_ms_p95,
                done->draw_ms_p50, done->draw_ms_p95, at(intervals_ms, 0.5), at(intervals_ms, 0.95));
  add_result("LIVEGS_LATENCY_CSV",
             "jumps,network_ms_each_way,seen_p50_ms,seen_p95_ms,submitted_p50_ms,submitted_p95_ms,sample_to_seen_p50_ms,sample_to_seen_p95_ms,draw_p50_ms,draw_p95_ms,"
             "picture_p50_ms,picture_p95_ms,goal_p95_ms",
             row);
  EXPECT_GT(seen_ms.front(), 4 + 4);  // the network alone
  EXPECT_LT(at(seen_ms, 0.95), at(intervals_ms, 0.95) < kUndisturbed_ms ? kBarP95_ms : kDisturbedP95_ms);
}

}  // namespace
}  // namespace livegs
