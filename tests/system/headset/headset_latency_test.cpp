// SPDX-License-Identifier: Apache-2.0
// Latency from controller motion to a changed picture, with the simulated runtime and 4 ms of network delay
// in each direction.
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "core/sanitizers.h"
#include "system/headset/headset_session.h"
#include "system/support/results_csv.h"

namespace livegs {
namespace {

constexpr int kJumps = 40;
// Latency bounds in ms, for the best of kMaxRuns runs with the CPU renderer on two cores. The looser bound
// applies if other programs took half of the machine in all runs. The share of other programs is measured
// independently of this process, so that a slow client cannot relax its own bound.
constexpr int kMaxRuns = 3;
constexpr double kBarP95_ms = 50, kUndisturbedShare = 0.5, kDisturbedP95_ms = 86;
// Bound of the processor time per picture, ms: client, server, network and runtime together. Other load
// hardly changes it.
constexpr double kBarCpu_ms = 10;
// Sanitizers dominate the times.
constexpr bool kSanitized = LIVEGS_ADDRESS_SANITIZER || LIVEGS_THREAD_SANITIZER;

// Processor time in seconds: all processors since boot, including steal time, and this process.
struct CpuTimes {
  double all_s = 0, own_s = 0;
  static CpuTimes now() {
    CpuTimes times;
    std::ifstream stat("/proc/stat");
    std::string name;
    std::array<double, 8> ticks{};  // user, nice, system, idle, iowait, irq, softirq, steal
    stat >> name;
    for (double& one : ticks) stat >> one;
    for (size_t i = 0; i < ticks.size(); ++i)
      times.all_s += i == 3 || i == 4 ? 0.0 : ticks[i] / static_cast<double>(::sysconf(_SC_CLK_TCK));
    rusage own{};
    ::getrusage(RUSAGE_SELF, &own);
    for (const timeval& one : {own.ru_utime, own.ru_stime})
      times.own_s += static_cast<double>(one.tv_sec) + 1e-6 * static_cast<double>(one.tv_usec);
    return times;
  }
};

double at(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<size_t>(std::lround(share * static_cast<double>(sorted.size() - 1)))];
}

// The CPU renderer is used, because a software Vulkan device takes ten times as long. A hand that holds a box
// jumps, and the first changed picture is searched for.
class HeadsetLatency : public HeadsetSession {
 protected:
  struct Measured {
    std::vector<double> seen_ms, submitted_ms, intervals_ms;  // ascending
    HeadsetRunSummary summary;
    double others_share = 0, cpu_ms = 0;  // other programs' share of the machine; processor time per picture
  };

  void measure(Measured& measured) {
    for (const char* file : {"frames.csv", "views.csv", "handles.csv"})
      std::filesystem::remove(folder_ / file);  // from a previous run
    const CpuTimes before = CpuTimes::now();
    const int64_t began_ns = now_ns();
    const auto done = run(floating({{"held", {0, 0, 0}}}), timeline(),
                          {.eye_size = "64x72",
                           .renderer = RendererChoice::Cpu,
                           .network_delay_ms = 4,
                           .marks = false,
                           .validates = false});
    const CpuTimes after = CpuTimes::now();
    ASSERT_TRUE(done) << done.error().message;
    expect_no_complaints();
    measured.summary = *done;
    const double own_s = after.own_s - before.own_s;
    const double machine_s =
        seconds_from_ns(now_ns() - began_ns) * static_cast<double>(::sysconf(_SC_NPROCESSORS_ONLN));
    measured.others_share = std::max(0.0, after.all_s - before.all_s - own_s) / machine_s;
    measured.cpu_ms = 1e3 * own_s / static_cast<double>(done->counts.pictures);
    find_pictures(measured);
    ASSERT_EQ(measured.seen_ms.size(), static_cast<size_t>(kJumps));
    for (auto* values : {&measured.seen_ms, &measured.submitted_ms, &measured.intervals_ms})
      std::sort(values->begin(), values->end());
    std::printf("other programs used %.0f %% of the machine; %.1f ms of processor time per picture\n",
                100 * measured.others_share, measured.cpu_ms);
    std::printf("sample to picture seen p50 %.1f, p95 %.1f ms\n", done->hand_to_picture_ms_p50,
                done->hand_to_picture_ms_p95);
    std::printf(
        "input latency: submitted p50 %.1f, p95 %.1f ms; seen p50 %.1f, p95 %.1f ms; drawing p50 %.1f, p95 "
        "%.1f ms, a picture each "
        "p50 %.1f, p95 %.1f ms\n",
        at(measured.submitted_ms, 0.5), at(measured.submitted_ms, 0.95), at(measured.seen_ms, 0.5),
        at(measured.seen_ms, 0.95), done->draw_ms_p50, done->draw_ms_p95, at(measured.intervals_ms, 0.5),
        at(measured.intervals_ms, 0.95));
  }

 private:
  static double jump_s(int i) { return 1.5 + 0.5037 * i; }  // not synchronised with the display or the server

  static std::string timeline() {
    std::string lines =
        "0 pose head 0 1.6 0 1 0 0 0\n0 pose right 0 1.6 -1 1 0 0 0\n0.5 input right.squeeze 1\n";
    for (int i = 0; i < kJumps; ++i) {
      char line[200];
      std::snprintf(line, sizeof line,
                    "%.5f pose right 0 %.3f -1 1 0 0 0\n%.5f pose right 0 %.3f -1 1 0 0 0\n",
                    jump_s(i) - 1e-5, i % 2 ? 1.7 : 1.6, jump_s(i), i % 2 ? 1.6 : 1.7);
      lines += line;
    }
    return lines + std::to_string(jump_s(kJumps - 1) + 0.6) + " do exit\n";
  }

  // The box is at rest before the next jump, so consecutive pictures have the same hash.
  void find_pictures(Measured& measured) const {
    const auto frames = rows(folder_ / "frames.csv");
    double last_s = 0;
    for (const auto& row : frames) {
      if (row.size() < 6 || row[4] != "0") continue;
      if (last_s > 0) measured.intervals_ms.push_back(1e3 * (std::stod(row[2]) - last_s));
      last_s = std::stod(row[2]);
    }
    for (int i = 0; i < kJumps; ++i) {
      std::string before;
      for (const auto& row : frames) {
        if (row.size() < 6 || row[4] != "0") continue;
        if (std::stod(row[2]) < jump_s(i)) {
          before = row[5];
        } else if (row[5] != before) {
          measured.submitted_ms.push_back(1e3 * (std::stod(row[2]) - jump_s(i)));
          measured.seen_ms.push_back(1e3 * (std::max(std::stod(row[2]), std::stod(row[3])) - jump_s(i)));
          break;
        }
      }
    }
  }
};

// Must run alone. If LIVEGS_LATENCY_CSV names a file, a row of the best run is appended.
TEST_F(HeadsetLatency, HandMotionIsShownInTime) {
  Measured best;
  double quietest_share = 1;
  int runs = 0;
  do {
    Measured measured;
    ASSERT_NO_FATAL_FAILURE(measure(measured));
    quietest_share = std::min(quietest_share, measured.others_share);
    if (runs == 0 || at(measured.seen_ms, 0.95) < at(best.seen_ms, 0.95)) best = std::move(measured);
  } while (++runs < kMaxRuns && at(best.seen_ms, 0.95) >= kBarP95_ms);
  char row[300];
  std::snprintf(row, sizeof row, "%d,4,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f,%.2f,%.1f,%d,%.0f",
                kJumps, at(best.seen_ms, 0.5), at(best.seen_ms, 0.95), at(best.submitted_ms, 0.5),
                at(best.submitted_ms, 0.95), best.summary.hand_to_picture_ms_p50,
                best.summary.hand_to_picture_ms_p95, best.summary.draw_ms_p50, best.summary.draw_ms_p95,
                at(best.intervals_ms, 0.5), at(best.intervals_ms, 0.95), best.others_share, best.cpu_ms, runs,
                kBarP95_ms);
  add_result("LIVEGS_LATENCY_CSV",
             "jumps,network_ms_each_way,seen_p50_ms,seen_p95_ms,submitted_p50_ms,submitted_p95_ms,sample_to_"
             "seen_p50_ms,sample_to_seen_p95_ms,draw_p50_ms,draw_p95_ms,"
             "picture_p50_ms,picture_p95_ms,others_share,cpu_ms_a_picture,runs,goal_p95_ms",
             row);
  EXPECT_GT(best.seen_ms.front(), 4 + 4);  // the network delay alone
  EXPECT_LT(at(best.seen_ms, 0.95),
            !kSanitized && quietest_share < kUndisturbedShare ? kBarP95_ms : kDisturbedP95_ms);
  if (!kSanitized) {
    EXPECT_LT(best.cpu_ms, kBarCpu_ms);
  }
}

}  // namespace
}  // namespace livegs
