// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "stream/frame_history.h"
#include "stream/received.h"
#include "viewer/force_study.h"
#include "xr/video_file.h"

namespace livegs {

// A force on a thing, as a video with its sentence beside it. First the frames are collected, from a moment before the
// force to a while after it; then they are drawn one after the other, evenly in simulated time, however slow drawing
// is. One thread.
class StudyRecording {
 public:
  static constexpr double kLead_s = 0.5, kTail_s = 1.5, kRate_hz = 30;

  // The folder is made. Writes NAME.mp4, NAME.txt (the sentence), NAME.json (the force as a scene file's event) and
  // NAME_camera.json, NAME being study_001 or the next that is free.
  static Result<StudyRecording> begin(const std::filesystem::path& folder, const ForceStudy& study,
                                      const Camera& camera, double tick_rate_hz);

  // While it collects.
  void add(const ReceivedFrame& frame);
  bool wants_force();              // once, when the server is to be asked
  void force_taken(uint64_t tick); // what it answered
  bool collecting() const { return !drawing_; }

  // While it draws: the drivers of the next picture; nothing when all are drawn.
  std::optional<DriverFrame> next() const;
  bool force_acts() const;  // in the next picture
  Result<void> keep(const Image& picture);
  Result<void> finish();

  const ForceStudy& study() const { return study_; }
  std::string progress() const;
  std::filesystem::path video_path() const { return stem_.string() + ".mp4"; }

 private:
  StudyRecording(std::filesystem::path stem, ForceStudy study, double tick_rate_hz)
      : stem_(std::move(stem)), study_(std::move(study)), tick_rate_hz_(tick_rate_hz) {}
  int64_t shown_ns() const;

  std::filesystem::path stem_;
  ForceStudy study_;
  double tick_rate_hz_;
  FrameHistory frames_{100'000};
  uint64_t newest_tick_ = 0;
  bool asked_ = false, drawing_ = false;
  std::optional<int64_t> force_begin_ns_;
  int64_t force_end_ns_ = 0;
  int drawn_ = 0;
  std::optional<VideoFile> video_;
};

}  // namespace livegs
