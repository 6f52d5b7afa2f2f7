// SPDX-License-Identifier: Apache-2.0
// From a controller that moves to a picture that has changed, through the simulated runtime and 4 ms of network each way.
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "system/headset_session.h"
#include "system/results_csv.h"

namespace livegs {
namespace {

constexpr int kJumps = 40;
// 95 of 100 on two cores that draw with the CPU: 43 found, 63 once beside other programs. Whether there were any is not asked of
// anything that this process does: a slower client leaves the others' share of the machine as it is.
constexpr double kBarP95_ms = 50, kUndisturbedShare = 0.1, kDisturbedP95_ms = 86;
// Client, server, network and headset together, which other programs hardly change: 5.2 found beside some that took 77 % of the
// machine.
constexpr double kBarCpu_ms = 10;
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;  // times are the sanitizer's
#else
constexpr bool kSanitized = false;
#endif

// Seconds of processor time: of all processors together since the machine began, what the host kept from it included, and of
// this process.
struct CpuTimes {
  double all_s = 0, own_s = 0;
  static CpuTimes now() {
    CpuTimes times;
    std::ifstream stat("/proc/stat");
    std::string name;
    std::array<double, 8> ticks{};  // user, nice, system, idle, iowait, irq, softirq, steal
    stat >> name;
    for (double& one : ticks) stat >> one;
    for (size_t i = 0; i < ticks.size(); ++i) times.all_s += i == 3 || i == 4 ? 0.0 : ticks[i] / static_cast<double>(::sysconf(_SC_CLK_TCK));
    rusage own{};
    ::getrusage(RUSAGE_SELF, &own);
    for (const timeval& one : {own.ru_utime, own.ru_stime}) times.own_s += static_cast<double>(one.tv_sec) + 1e-6 * static_cast<double>(one.tv_usec);
    return times;
  }
};

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
  const CpuTimes before_run = CpuTimes::now();
  const int64_t began_ns = now_ns();
  const auto done = run(floating({{"held", {0, 0, 0}}}), timeline,
                        {.eye_size = "64x72", .renderer = RendererChoice::Cpu, .network_delay_ms = 4, .marks = false, .validates = false});
  const CpuTimes after_run = CpuTimes::now();
  ASSERT_TRUE(done) << done.error().message;
  expect_no_complaints();
  const double own_s = after_run.own_s - before_run.own_s;
  const double machine_s = seconds_from_ns(now_ns() - began_ns) * static_cast<double>(::sysconf(_SC_NPROCESSORS_ONLN));
  const double others_share = std::max(0.0, after_run.all_s - before_run.all_s - own_s) / machine_s;
  const double cpu_ms = 1e3 * own_s / static_cast<double>(done->counts.pictures);
  std::printf("others took %.0f %% of the machine; %.1f ms of processor time a picture\n", 100 * others_share, cpu_ms);

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
  std::snprintf(row, sizeof row, "%d,4,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f,%.2f,%.1f,50", kJumps, at(seen_ms, 0.5), at(seen_ms, 0.95),
                at(submitted_ms, 0.5), at(submitted_ms, 0.95), done->hand_to_picture_ms_p50, done->hand_to_picture_ms_p95,
                done->draw_ms_p50, done->draw_ms_p95, at(intervals_ms, 0.5), at(intervals_ms, 0.95), others_share, cpu_ms);
  add_result("LIVEGS_LATENCY_CSV",
             "jumps,network_ms_each_way,seen_p50_ms,seen_p95_ms,submitted_p50_ms,submitted_p95_ms,sample_to_seen_p50_ms,sample_to_seen_p95_ms,draw_p50_ms,draw_p95_ms,"
             "picture_p50_ms,picture_p95_ms,others_share,cpu_ms_a_picture,goal_p95_ms",
             row);
  EXPECT_GT(seen_ms.front(), 4 + 4);  // the network alone
  EXPECT_LT(at(seen_ms, 0.95), !kSanitized && others_share < kUndisturbedShare ? kBarP95_ms : kDisturbedP95_ms);
  if (!kSanitized) EXPECT_LT(cpu_ms, kBarCpu_ms);
}

}  // namespace
}  // namespace livegs
