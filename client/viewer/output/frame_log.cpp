// SPDX-License-Identifier: Apache-2.0
#include "viewer/output/frame_log.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "core/clock.h"
#include "core/percentile.h"
#include "core/written_files.h"

namespace livegs {
namespace {

std::unique_ptr<std::FILE, int (*)(std::FILE*)> open(const std::filesystem::path& path, const char* header) {
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "w"), &std::fclose);
  if (!file) return file;
  std::fprintf(file.get(), "%s\n", header);
  note_written(path);
  return file;
}

Error cannot_write(const std::filesystem::path& path) {
  return invalid_argument(path.string() + ": the file cannot be written: " + std::strerror(errno) +
                          "; choose another folder with --output");
}

}  // namespace

std::optional<double> age_ms(const ReceivedFrame& frame) {
  if (!frame.clock) return std::nullopt;
  return milliseconds_from_ns(frame.received_ns + frame.clock->offset_ns - frame.stepped_ns);
}

Result<ReceivedLog> ReceivedLog::create(const std::filesystem::path& path) {
  auto file = open(path,
                   "tick,stepped_ns,encode_begun_ns,sent_ns,received_ns,decoded_ns,clock_offset_ns,clock_"
                   "uncertainty_ns,age_ms,bytes,server_step_ms,input_sequence,held_hands");
  if (!file) return cannot_write(path);
  return ReceivedLog(std::move(file));
}

void ReceivedLog::add(const ReceivedFrame& frame) {
  std::fprintf(file_.get(), "%llu,%lld,%lld,%lld,%lld,%lld,", static_cast<unsigned long long>(frame.tick),
               static_cast<long long>(frame.stepped_ns), static_cast<long long>(frame.encode_begun_ns),
               static_cast<long long>(frame.sent_ns), static_cast<long long>(frame.received_ns),
               static_cast<long long>(frame.decoded_ns));
  if (const auto age = age_ms(frame)) {
    std::fprintf(file_.get(), "%lld,%lld,%.3f,", static_cast<long long>(frame.clock->offset_ns),
                 static_cast<long long>(frame.clock->uncertainty_ns), *age);
    age_ms_.push_back(*age);
    clock_uncertainty_ms_ = milliseconds_from_ns(frame.clock->uncertainty_ns);
  } else {
    std::fprintf(file_.get(), ",,,");
  }
  std::fprintf(file_.get(), "%zu,%.3f,%llu,%zu\n", frame.bytes, frame.step_ms,
               static_cast<unsigned long long>(frame.input_sequence), frame.hands.size());
  if (bytes_.empty()) first_ns_ = frame.received_ns;
  if (last_tick_ && frame.tick > *last_tick_) missed_ticks_ += frame.tick - *last_tick_ - 1;
  last_tick_ = frame.tick;
  last_ns_ = frame.received_ns;
  bytes_.push_back(static_cast<double>(frame.bytes));
  step_ms_.push_back(frame.step_ms);
}

void ReceivedLog::reset() { last_tick_.reset(); }

ReceivedLog::Summary ReceivedLog::summary() const {
  Summary summary;
  summary.frames = bytes_.size();
  if (bytes_.empty()) return summary;
  summary.missed_ticks = missed_ticks_;
  summary.clock_uncertainty_ms = clock_uncertainty_ms_;
  summary.seconds = seconds_from_ns(last_ns_ - first_ns_);
  if (summary.seconds > 0) summary.rate_hz = static_cast<double>(summary.frames - 1) / summary.seconds;
  summary.age_ms_p50 = percentile(age_ms_, 0.50);
  summary.age_ms_p99 = percentile(age_ms_, 0.99);
  summary.bytes_p50 = percentile(bytes_, 0.50);
  summary.bytes_p99 = percentile(bytes_, 0.99);
  summary.step_ms_p50 = percentile(step_ms_, 0.50);
  summary.step_ms_p99 = percentile(step_ms_, 0.99);
  return summary;
}

Result<DrawnLog> DrawnLog::create(const std::filesystem::path& path) {
  auto file =
      open(path,
           "picture,simulated_s,tick,received_ns,age_ms,lag_ms,skin_ms,raster_ms,bytes,server_step_ms,"
           "device_skin_ms,device_project_ms,device_sort_ms,device_draw_ms,device_resolve_ms");
  if (!file) return cannot_write(path);
  return DrawnLog(std::move(file));
}

void DrawnLog::add(const Row& row) {
  std::fprintf(file_.get(), "%llu,%.6f,%llu,%lld,%.3f,%.3f,%.3f,%.3f,%zu,%.3f,",
               static_cast<unsigned long long>(row.index), row.simulated_s,
               static_cast<unsigned long long>(row.tick), static_cast<long long>(row.received_ns), row.age_ms,
               row.lag_ms, row.skin_ms, row.raster_ms, row.bytes, row.server_step_ms);
  if (row.device)
    std::fprintf(file_.get(), "%.3f,%.3f,%.3f,%.3f,%.3f\n", row.device->skin_ms, row.device->project_ms,
                 row.device->sort_ms, row.device->draw_ms, row.device->resolve_ms);
  else
    std::fputs(",,,,\n", file_.get());
  skin_ms_.push_back(row.skin_ms);
  raster_ms_.push_back(row.raster_ms);
}

DrawnLog::Summary DrawnLog::summary() const {
  return {skin_ms_.size(), percentile(skin_ms_, 0.50), percentile(skin_ms_, 0.99),
          percentile(raster_ms_, 0.50), percentile(raster_ms_, 0.99)};
}

}  // namespace livegs
