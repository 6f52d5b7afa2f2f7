// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "xr/display.h"
#include "xr/display/video_file.h"

namespace livegs {

struct OffscreenOptions {
  std::filesystem::path folder;
  double rate_hz = 30;  // of the video
  int width = 640, height = 480;
  int png_every = 30;  // saves every Nth picture as frame_NNNNN.png; 0: none
  bool video = true;   // writes out.mp4; without ffmpeg, every picture as PNG and a warning
};

// A display that writes pictures to files. Its clock counts pictures, not wall time: picture k is displayed
// at k / rate, however long drawing takes, so a slow machine produces the same smooth video.
class OffscreenDisplay final : public Display {
 public:
  static Result<std::unique_ptr<OffscreenDisplay>> open(const OffscreenOptions& options);

  void set_camera(const Camera& camera) { camera_ = camera; }

  std::optional<PlannedFrame> wait_frame() override;
  Result<void> submit(const PlannedFrame& frame, std::span<const Image> images) override;
  Result<void> finish() override;

  uint64_t pictures() const { return pictures_; }
  bool has_video() const { return video_.has_value(); }

 private:
  explicit OffscreenDisplay(const OffscreenOptions& options) : options_(options) {}

  bool is_saved(uint64_t index) const;  // as PNG

  OffscreenOptions options_;
  Camera camera_;
  std::optional<VideoFile> video_;
  uint64_t planned_ = 0;
  uint64_t pictures_ = 0;
};

}  // namespace livegs
