// SPDX-License-Identifier: Apache-2.0
#include "xr/display/video_file.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <string>
#include <vector>

extern char** environ;

namespace livegs {

Result<VideoFile> VideoFile::create(const std::filesystem::path& path, int width, int height,
                                    double rate_hz) {
  // A terminated ffmpeg must show as a failed write, not as a signal.
  signal(SIGPIPE, SIG_IGN);
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0)
    return Error{ErrorCode::Internal, path.string() + ": the pipe to ffmpeg cannot be created"};
  const std::string size = std::to_string(width) + "x" + std::to_string(height);
  char rate[32];
  std::snprintf(rate, sizeof rate, "%.6f", rate_hz);
  std::vector<std::string> words = {"ffmpeg",     "-y",
                                    "-nostdin",   "-loglevel",
                                    "error",      "-f",
                                    "rawvideo",   "-pixel_format",
                                    "rgb24",      "-video_size",
                                    size,         "-framerate",
                                    rate,         "-i",
                                    "pipe:0",     "-an",
                                    "-vf",        "pad=ceil(iw/2)*2:ceil(ih/2)*2",
                                    "-c:v",       "libx264",
                                    "-preset",    "fast",
                                    "-crf",       "18",
                                    "-pix_fmt",   "yuv420p",
                                    "-movflags",  "+faststart",
                                    path.string()};
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[0], STDIN_FILENO);
  // Termination signals of the client must not reach ffmpeg, which ends when its input is closed.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  pid_t process = -1;
  const int failed = posix_spawnp(&process, "ffmpeg", &actions, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  ::close(ends[0]);
  if (failed != 0) {
    ::close(ends[1]);
    return unsupported(path.string() + ": ffmpeg was not found; install it to write videos");
  }
  return VideoFile(path, ends[1], process);
}

VideoFile::VideoFile(VideoFile&& other) noexcept
    : path_(std::move(other.path_)),
      pipe_(std::exchange(other.pipe_, -1)),
      process_(std::exchange(other.process_, -1)) {}

VideoFile::~VideoFile() { (void)finish(); }

Result<void> VideoFile::add(const Image& image) {
  const std::vector<uint8_t> bytes = rgb_bytes(image);
  for (size_t written = 0; written < bytes.size();) {
    const ssize_t count = ::write(pipe_, bytes.data() + written, bytes.size() - written);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0)
      return Error{ErrorCode::Internal, path_.string() + ": ffmpeg ended early; the video is incomplete"};
    written += static_cast<size_t>(count);
  }
  return {};
}

Result<void> VideoFile::finish() {
  if (pipe_ < 0) return {};
  ::close(std::exchange(pipe_, -1));
  int status = 0;
  while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) {
  }
  if (status != 0) return Error{ErrorCode::Internal, path_.string() + ": ffmpeg could not write the video"};
  return {};
}

}  // namespace livegs
