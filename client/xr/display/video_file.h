// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <filesystem>

#include "core/result.h"
#include "splat/image.h"

namespace livegs {

// An H.264 video, 4:2:0, written through the `ffmpeg` command; playable everywhere. Odd sizes are padded by
// one pixel. The file is readable while it grows, and if its writer is killed: it consists of fragments of
// one second until finish() gives it an index.
class VideoFile {
 public:
  // Unsupported if ffmpeg is not installed.
  static Result<VideoFile> create(const std::filesystem::path& path, int width, int height, double rate_hz);
  VideoFile(VideoFile&& other) noexcept;
  VideoFile& operator=(VideoFile&&) = delete;
  ~VideoFile();

  pid_t process() const { return process_; }  // the encoder

  Result<void> add(const Image& image);  // of the size given to create()
  Result<void> finish();                 // waits for the file; may be called repeatedly

 private:
  VideoFile(std::filesystem::path path, int pipe, pid_t process)
      : path_(std::move(path)), pipe_(pipe), process_(process) {}
  std::filesystem::path path_;
  int pipe_ = -1;
  pid_t process_ = -1;
};

}  // namespace livegs
