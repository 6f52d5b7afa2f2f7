// SPDX-License-Identifier: GPL-3.0-or-later
#include "fit/tracks/video_frames.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/file.h"
#include "core/text/format_text.h"

extern char** environ;

namespace livegs {
namespace {

constexpr int kMaxVideoSide_px = 8192;

int exit_status(pid_t process) {
  int status = 0;
  while (::waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

// Reads up to the next line feed, which is left out. False at the end.
bool read_header_line(std::FILE* file, std::string& line) {
  line.clear();
  for (int c = std::fgetc(file); c != '\n'; c = std::fgetc(file)) {
    if (c == EOF || line.size() > 1000) return false;
    line += static_cast<char>(c);
  }
  return true;
}

}  // namespace

VideoFrames::~VideoFrames() {
  if (!pipe_) return;
  pipe_.reset();
  ::kill(process_, SIGTERM);  // reading may have ended early
  exit_status(process_);
}

Result<VideoFrames> VideoFrames::open(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    return not_found(path.string() + ": is not a file; give the path of a video");
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return file_error(path, "the pipe to ffmpeg cannot be created");
  // YUV4MPEG2 is raw frames with a header of their size and rate. "file:" keeps a name with a colon from
  // being read as the address of something else.
  std::vector<std::string> words = {
      "ffmpeg",   "-nostdin", "-loglevel", "error", "-i", "file:" + path.string(), "-an",
      "-pix_fmt", "gray",     "-strict",   "-1",    "-f", "yuv4mpegpipe",          "pipe:1"};
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  // Its own group: an interrupt from the terminal ends the search, not the video.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  VideoFrames video;
  video.name_ = path.string();
  const int failed =
      posix_spawnp(&video.process_, "ffmpeg", &actions, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  ::close(ends[1]);
  if (failed != 0) {
    ::close(ends[0]);
    return not_found("ffmpeg: cannot be started; install it (Debian package ffmpeg), or give --tracks");
  }
  video.pipe_.reset(::fdopen(ends[0], "rb"));
  std::string header;
  if (!read_header_line(video.pipe_.get(), header) || !header.starts_with("YUV4MPEG2 "))
    return invalid_data(path.string() + ": has no pictures that ffmpeg can read; give a video");
  long rate = 0, per = 0;
  for (size_t at = header.find(' '); at != std::string::npos; at = header.find(' ', at + 1)) {
    const char* word = header.c_str() + at + 1;
    if (*word == 'W') video.width_ = std::atoi(word + 1);
    if (*word == 'H') video.height_ = std::atoi(word + 1);
    if (*word == 'F') std::sscanf(word + 1, "%ld:%ld", &rate, &per);
  }
  video.rate_hz_ = per > 0 ? static_cast<double>(rate) / static_cast<double>(per) : 0.0;
  if (video.width_ < 1 || video.height_ < 1 || video.width_ > kMaxVideoSide_px ||
      video.height_ > kMaxVideoSide_px || !(video.rate_hz_ > 0))
    return unsupported(format_text("%s: has %d x %d pixels at %.3g frames/s; give at most %d x %d",
                                   path.c_str(), video.width_, video.height_, video.rate_hz_,
                                   kMaxVideoSide_px, kMaxVideoSide_px));
  return video;
}

Result<bool> VideoFrames::next(GreyPicture& picture) {
  if (!pipe_) return false;
  std::string header;
  if (!read_header_line(pipe_.get(), header)) {
    pipe_.reset();
    if (exit_status(process_) != 0)
      return invalid_data(name_ + ": is damaged, and ffmpeg stopped; export or copy it again");
    return false;
  }
  picture.width = width_;
  picture.height = height_;
  picture.pixels.resize(static_cast<size_t>(width_) * static_cast<size_t>(height_));
  if (!header.starts_with("FRAME") ||
      std::fread(picture.pixels.data(), 1, picture.pixels.size(), pipe_.get()) != picture.pixels.size())
    return invalid_data(name_ + ": is damaged, and its last frame is incomplete; export or copy it again");
  return true;
}

}  // namespace livegs
