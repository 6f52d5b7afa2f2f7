// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/result.h"

namespace livegs {

// An 8-bit picture without colour, rows from the top.
struct GreyPicture {
  int width = 0, height = 0;
  std::vector<uint8_t> pixels;
};

// The frames of a video, one after the other, at the constant rate of the file. The program ffmpeg decodes
// it, in a process of its own. One thread.
class VideoFrames {
 public:
  // Fails if ffmpeg is not installed or the file has no pictures.
  static Result<VideoFrames> open(const std::filesystem::path& path);
  VideoFrames(VideoFrames&&) noexcept = default;
  VideoFrames& operator=(VideoFrames&&) noexcept = default;
  ~VideoFrames();

  int width() const { return width_; }
  int height() const { return height_; }
  double rate_hz() const { return rate_hz_; }
  // False at the end of the video; an error if it is damaged.
  Result<bool> next(GreyPicture& picture);

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  VideoFrames() = default;

  std::string name_;
  std::unique_ptr<std::FILE, Close> pipe_;
  pid_t process_ = -1;
  int width_ = 0, height_ = 0;
  double rate_hz_ = 0;
};

}  // namespace livegs
