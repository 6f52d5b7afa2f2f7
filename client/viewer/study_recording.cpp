// SPDX-License-Identifier: Apache-2.0
#include "viewer/study_recording.h"

#include <google/protobuf/util/json_util.h>

#include <cmath>

#include "core/file.h"
#include "core/format_text.h"
#include "viewer/camera_file.h"

namespace livegs {
namespace {

constexpr int64_t ns(double seconds) { return static_cast<int64_t>(seconds * 1e9); }

}  // namespace

Result<StudyRecording> StudyRecording::begin(const std::filesystem::path& folder, const ForceStudy& study,
                                             const Camera& camera, double tick_rate_hz) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return invalid_argument(folder.string() + ": cannot be made: " + error.message());
  std::filesystem::path stem;
  for (int number = 1; stem.empty() || std::filesystem::exists(stem.string() + ".txt"); ++number) {
    stem = folder / format_text("study_%03d", number);
  }
  std::string json;
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  options.add_whitespace = true;
  if (!google::protobuf::util::MessageToJsonString(study.message(), &json, options).ok()) json = "{}";
  for (const auto& [ending, text] : {std::pair(".txt", study.sentence() + "\n"), std::pair(".json", json)}) {
    if (auto written = write_file_atomically(stem.string() + ending, std::string_view(text)); !written) return written.error();
  }
  if (auto written = write_camera_file(stem.string() + "_camera.json", camera); !written) return written.error();
  return StudyRecording(stem, study, tick_rate_hz);
}

void StudyRecording::add(const ReceivedFrame& frame) {
  frames_.add(*frame.drivers);
  newest_tick_ = frame.tick;
  if (force_begin_ns_ && frames_.newest().simulated_ns >= force_end_ns_ + ns(kTail_s)) drawing_ = true;
}

bool StudyRecording::wants_force() {
  if (asked_ || frames_.empty() || frames_.newest().simulated_ns < frames_.oldest().simulated_ns + ns(kLead_s)) {
    return false;
  }
  return asked_ = true;
}

void StudyRecording::force_taken(uint64_t tick) {
  const double ticks = static_cast<double>(tick) - static_cast<double>(newest_tick_);
  force_begin_ns_ = frames_.newest().simulated_ns + ns(ticks / tick_rate_hz_);
  force_end_ns_ = *force_begin_ns_ + ns(study_.duration_s());
}

int64_t StudyRecording::shown_ns() const {
  return frames_.oldest().simulated_ns + std::llround(1e9 * drawn_ / kRate_hz);
}

std::optional<DriverFrame> StudyRecording::next() const {
  if (!drawing_ || shown_ns() > frames_.newest().simulated_ns) return std::nullopt;
  return frames_.at(shown_ns());
}

bool StudyRecording::force_acts() const {
  return force_begin_ns_ && shown_ns() >= *force_begin_ns_ && shown_ns() < force_end_ns_;
}

Result<void> StudyRecording::keep(const Image& picture) {
  if (!video_) {
    auto video = VideoFile::create(video_path(), picture.width, picture.height, kRate_hz);
    if (!video) return video.error();
    video_.emplace(std::move(*video));
  }
  ++drawn_;
  return video_->add(picture);
}

Result<void> StudyRecording::finish() { return video_ ? video_->finish() : Result<void>(); }

std::string StudyRecording::progress() const {
  if (!drawing_) {
    const double passed_s =
        frames_.empty() ? 0 : 1e-9 * static_cast<double>(frames_.newest().simulated_ns - frames_.oldest().simulated_ns);
    return format_text("Recording: %.1f of %.1f s", passed_s, kLead_s + study_.duration_s() + kTail_s);
  }
  const double all = 1 + kRate_hz * 1e-9 * static_cast<double>(frames_.newest().simulated_ns - frames_.oldest().simulated_ns);
  return format_text("Drawing picture %d of %.0f", drawn_ + 1, std::floor(all));
}

}  // namespace livegs
