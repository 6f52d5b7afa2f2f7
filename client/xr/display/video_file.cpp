// SPDX-License-Identifier: Apache-2.0
#include "xr/display/video_file.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "core/file.h"
#include "core/written_files.h"

extern char** environ;

namespace livegs {
namespace {

// Pictures between two fragments of the file, seconds. A file whose writer was killed lacks at most this and
// the encoder's look-ahead of about a second. With less, the file is larger.
constexpr double kFragment_s = 1;

// Starts ffmpeg with this input; -1 if it is not installed. Its group is its own: termination signals of the
// client must not reach ffmpeg, which ends when its input is closed.
pid_t spawn_ffmpeg(std::vector<std::string> words, int input) {
  words.insert(words.begin(), {"ffmpeg", "-y", "-nostdin", "-loglevel", "error"});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  if (input >= 0) posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  pid_t process = -1;
  const int failed = posix_spawnp(&process, "ffmpeg", &actions, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return failed == 0 ? process : -1;
}

bool succeeded(pid_t process) {
  int status = 0;
  while (::waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  return status == 0;
}

// Rewrites a complete file of fragments as one with an index at the beginning, which more players can seek.
// Keeps the file if that fails.
void defragment(const std::filesystem::path& path) {
  const std::string indexed = path.string() + ".tmp";
  const pid_t process =
      spawn_ffmpeg({"-i", path.string(), "-c", "copy", "-movflags", "+faststart", "-f", "mp4", indexed}, -1);
  std::error_code failed;
  if (process >= 0 && succeeded(process)) std::filesystem::rename(indexed, path, failed);
  std::filesystem::remove(indexed, failed);
}

}  // namespace

Result<VideoFile> VideoFile::create(const std::filesystem::path& path, int width, int height,
                                    double rate_hz) {
  // A terminated ffmpeg must show as a failed write, not as a signal.
  signal(SIGPIPE, SIG_IGN);
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return file_error(path, "the pipe to ffmpeg cannot be created");
  const std::string size = std::to_string(width) + "x" + std::to_string(height);
  char rate[32];
  std::snprintf(rate, sizeof rate, "%.6f", rate_hz);
  const int fragment = std::max(1, static_cast<int>(std::lround(kFragment_s * rate_hz)));
  const pid_t process = spawn_ffmpeg({"-f",
                                      "rawvideo",
                                      "-pixel_format",
                                      "rgb24",
                                      "-video_size",
                                      size,
                                      "-framerate",
                                      rate,
                                      "-i",
                                      "pipe:0",
                                      "-an",
                                      "-vf",
                                      "pad=ceil(iw/2)*2:ceil(ih/2)*2",
                                      "-c:v",
                                      "libx264",
                                      "-preset",
                                      "fast",
                                      "-crf",
                                      "18",
                                      "-g",
                                      std::to_string(fragment),
                                      "-pix_fmt",
                                      "yuv420p",
                                      "-movflags",
                                      "+frag_keyframe+empty_moov+default_base_moof",
                                      "-flush_packets",
                                      "1",
                                      path.string()},
                                     ends[0]);
  ::close(ends[0]);
  if (process < 0) {
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
      return Error{
          ErrorCode::Internal,
          path_.string() + ": ffmpeg ended early, so the video lacks its end; check the free disk space"};
    written += static_cast<size_t>(count);
  }
  return {};
}

Result<void> VideoFile::finish() {
  if (pipe_ < 0) return {};
  ::close(std::exchange(pipe_, -1));
  if (!succeeded(process_)) {
    return Error{ErrorCode::Internal, path_.string() +
                                          ": ffmpeg failed, so the video is incomplete; check the free disk "
                                          "space and that ffmpeg has libx264"};
  }
  defragment(path_);
  note_written(path_);
  return {};
}

}  // namespace livegs
