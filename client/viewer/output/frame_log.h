// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "render/splat_renderer.h"
#include "stream/received/received.h"

namespace livegs {

// Time from the end of the frame's server step to its reception; nothing before the first clock estimate.
std::optional<double> age_ms(const ReceivedFrame& frame);

// Writes frames.csv, one row per received frame, and computes a summary. stepped_ns, encode_begun_ns and
// sent_ns are server clock; received_ns and decoded_ns are client clock. The server clock is ahead by
// clock_offset_ns, plus or minus clock_uncertainty_ns. One thread.
class ReceivedLog {
 public:
  static Result<ReceivedLog> create(const std::filesystem::path& path);
  void add(const ReceivedFrame& frame);
  // Restarts the tick count, after a server restart.
  void reset();

  struct Summary {
    uint64_t frames = 0;
    uint64_t missed_ticks = 0;  // within the received range: dropped by the server
    double seconds = 0;
    double rate_hz = 0;                     // frames per second
    double age_ms_p50 = 0, age_ms_p99 = 0;  // end of the server's step to reception
    double clock_uncertainty_ms = 0;        // of the ages, at the end
    double bytes_p50 = 0, bytes_p99 = 0;
    double step_ms_p50 = 0, step_ms_p99 = 0;  // on the server
  };
  Summary summary() const;

 private:
  using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;
  explicit ReceivedLog(File file) : file_(std::move(file)) {}
  File file_;
  std::vector<double> age_ms_, bytes_, step_ms_;
  std::optional<uint64_t> last_tick_;
  uint64_t missed_ticks_ = 0;
  double clock_uncertainty_ms_ = 0;
  int64_t first_ns_ = 0, last_ns_ = 0;
};

// Writes timings.csv, one row per drawn picture. Device times are empty without a device timer.
class DrawnLog {
 public:
  static Result<DrawnLog> create(const std::filesystem::path& path);

  struct Row {
    uint64_t index = 0;
    double simulated_s = 0;  // displayed simulated time
    uint64_t tick = 0;       // newest frame in it
    int64_t received_ns = 0;
    double age_ms = 0;  // age of that frame at reception
    double lag_ms = 0;  // from reception to the end of drawing, including a backlog
    double skin_ms = 0, raster_ms = 0;
    size_t bytes = 0;
    double server_step_ms = 0;
    std::optional<DeviceTimes> device = {};
  };
  void add(const Row& row);

  struct Summary {
    uint64_t pictures = 0;
    double skin_ms_p50 = 0, skin_ms_p99 = 0, raster_ms_p50 = 0, raster_ms_p99 = 0;
  };
  Summary summary() const;

 private:
  using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;
  explicit DrawnLog(File file) : file_(std::move(file)) {}
  File file_;
  std::vector<double> skin_ms_, raster_ms_;
};

}  // namespace livegs
