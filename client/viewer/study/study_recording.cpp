// SPDX-License-Identifier: Apache-2.0
#include "viewer/study/study_recording.h"

#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <cmath>

#include "core/file.h"
#include "core/text/format_text.h"
#include "core/written_files.h"
#include "splat/camera_file.h"

namespace livegs {
namespace {

constexpr int64_t ns(double seconds) { return static_cast<int64_t>(seconds * 1e9); }

}  // namespace

Result<StudyRecording> StudyRecording::begin(const std::filesystem::path& folder,
                                             std::vector<ForceStudy> studies, const Camera& camera,
                                             double tick_rate_hz) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    return invalid_argument(folder.string() + ": the folder cannot be created: " + error.message() +
                            "; choose another folder with --output");
  std::filesystem::path stem;
  for (int number = 1; stem.empty() || std::filesystem::exists(stem.string() + ".txt"); ++number) {
    stem = folder / format_text("study_%03d", number);
  }
  std::string json;
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  options.add_whitespace = true;
  for (const ForceStudy& study : studies) {
    std::string one;
    if (!google::protobuf::util::MessageToJsonString(study.message(), &one, options).ok()) one = "{}";
    json += (json.empty() ? "" : ",\n") + one;
  }
  if (studies.size() > 1) json = "[\n" + json + "]\n";
  for (const auto& [ending, text] :
       {std::pair(".txt", sentence_of(studies) + "\n"), std::pair(".json", json)}) {
    if (auto written = write_file_atomically(stem.string() + ending, std::string_view(text)); !written)
      return written.error();
  }
  if (auto written = write_camera_file(stem.string() + "_camera.json", camera); !written)
    return written.error();
  return StudyRecording(stem, std::move(studies), tick_rate_hz);
}

void StudyRecording::add(const ReceivedFrame& frame) {
  frames_.add(*frame.drivers);
  newest_tick_ = frame.tick;
  const auto over = [&](const Span& span) {
    return frames_.newest().simulated_ns >= span.end_ns + ns(kTail_s);
  };
  if (taken_.size() == studies_.size() && std::all_of(taken_.begin(), taken_.end(), over)) drawing_ = true;
}

bool StudyRecording::wants_force() {
  if (asked_ || frames_.empty() ||
      frames_.newest().simulated_ns < frames_.oldest().simulated_ns + ns(kLead_s)) {
    return false;
  }
  return asked_ = true;
}

void StudyRecording::force_taken(uint64_t tick) {
  const double ticks = static_cast<double>(tick) - static_cast<double>(newest_tick_);
  if (taken_.size() == studies_.size()) return;
  const int64_t begin_ns = frames_.newest().simulated_ns + ns(ticks / tick_rate_hz_);
  taken_.push_back({begin_ns, begin_ns + ns(studies_[taken_.size()].duration_s())});
}

int64_t StudyRecording::shown_ns() const {
  return frames_.oldest().simulated_ns + std::llround(1e9 * drawn_ / kRate_hz);
}

std::optional<DriverFrame> StudyRecording::next() const {
  if (!drawing_ || shown_ns() > frames_.newest().simulated_ns) return std::nullopt;
  return frames_.at(shown_ns());
}

bool StudyRecording::acts(size_t study) const {
  return study < taken_.size() && shown_ns() >= taken_[study].begin_ns && shown_ns() < taken_[study].end_ns;
}

double StudyRecording::longest_s() const {
  double longest = 0;
  for (const ForceStudy& study : studies_) longest = std::max(longest, study.duration_s());
  return longest;
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

Result<void> StudyRecording::finish() {
  for (const char* ending : {".txt", ".json"}) note_written(stem_.string() + ending);
  return video_ ? video_->finish() : Result<void>();
}

void StudyRecording::abandon() {
  std::error_code ignored;
  for (const char* ending : {".txt", ".json", "_camera.json"})
    std::filesystem::remove(stem_.string() + ending, ignored);
}

std::string StudyRecording::progress() const {
  if (!drawing_) {
    const double passed_s =
        frames_.empty()
            ? 0
            : 1e-9 * static_cast<double>(frames_.newest().simulated_ns - frames_.oldest().simulated_ns);
    return format_text("Recording: %.1f of %.1f s", passed_s, kLead_s + longest_s() + kTail_s);
  }
  return format_text("Drawing picture %d of %d", drawn_ + 1, pictures());
}

int StudyRecording::pictures() const {
  const double seconds =
      1e-9 * static_cast<double>(frames_.newest().simulated_ns - frames_.oldest().simulated_ns);
  return 1 + static_cast<int>(std::floor(kRate_hz * seconds));
}

std::string StudyRecording::drawn() const {
  return format_text("%d of %d pictures, %.1f of %.1f s", drawn_, pictures(), drawn_ / kRate_hz,
                     pictures() / kRate_hz);
}

}  // namespace livegs
