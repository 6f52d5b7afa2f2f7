// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "stream/received/frame_history.h"
#include "stream/received/received.h"
#include "viewer/study/force_study.h"
#include "xr/display/video_file.h"

namespace livegs {

// Records one or more forces as a video with a description. Frames are collected from shortly before the
// force to shortly after it, and then drawn evenly in simulated time, independent of drawing speed. One
// thread.
class StudyRecording {
 public:
  static constexpr double kLead_s = 0.5, kTail_s = 1.5, kRate_hz = 30;

  // Creates the folder. Writes NAME.mp4, NAME.txt (the description), NAME.json (the force as a scene file's
  // event, or an array of them) and NAME_camera.json; NAME is study_001 or the next free one. Precondition:
  // at least one study, each with a target.
  static Result<StudyRecording> begin(const std::filesystem::path& folder, std::vector<ForceStudy> studies,
                                      const Camera& camera, double tick_rate_hz);

  // Collecting.
  void add(const ReceivedFrame& frame);
  bool wants_force();               // true once: the caller must request all forces, in order
  void force_taken(uint64_t tick);  // tick of the reply to the next request
  bool collecting() const { return !drawing_; }

  // An object's kernels were renumbered.
  void find_kernels_again(uint32_t object_id, const SceneView& view) {
    for (ForceStudy& study : studies_) study.find_kernel_again(object_id, view);
  }

  // Drawing: the drivers of the next picture; nothing when all are drawn.
  std::optional<DriverFrame> next() const;
  bool acts(size_t study) const;  // in the next picture
  Result<void> keep(const Image& picture);
  Result<void> finish();
  void abandon();  // removes the files of begin(); no further call is allowed
  // Drawn part of the video, for an early end: "12 of 70 pictures, 0.4 of 2.3 s".
  std::string drawn() const;
  bool any_drawn() const { return drawn_ > 0; }

  const std::vector<ForceStudy>& studies() const { return studies_; }
  std::string sentence() const { return sentence_of(studies_); }
  std::string progress() const;
  std::filesystem::path video_path() const { return stem_.string() + ".mp4"; }

 private:
  StudyRecording(std::filesystem::path stem, std::vector<ForceStudy> studies, double tick_rate_hz)
      : stem_(std::move(stem)), studies_(std::move(studies)), tick_rate_hz_(tick_rate_hz) {}
  double longest_s() const;
  int pictures() const;  // total of the collected frames
  int64_t shown_ns() const;

  std::filesystem::path stem_;
  std::vector<ForceStudy> studies_;
  double tick_rate_hz_;
  FrameHistory frames_{100'000};
  uint64_t newest_tick_ = 0;
  bool asked_ = false, drawing_ = false;
  struct Span {
    int64_t begin_ns = 0, end_ns = 0;
  };
  std::vector<Span> taken_;  // of the first studies
  int drawn_ = 0;
  std::optional<VideoFile> video_;
};

}  // namespace livegs
