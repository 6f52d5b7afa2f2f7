// SPDX-License-Identifier: Apache-2.0
#include "trust/state_folder.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "core/file.h"

namespace livegs {
namespace {

constexpr uint64_t kMaxSecretBytes = 4 << 20;

}  // namespace

Result<std::filesystem::path> state_folder(const std::filesystem::path& given) {
  if (!given.empty()) return given;
  const char* state = std::getenv("XDG_STATE_HOME");
  if (state != nullptr && *state == '/') return std::filesystem::path(state) / "livegs";
  const char* home = std::getenv("HOME");
  if (home != nullptr && *home == '/') return std::filesystem::path(home) / ".local" / "state" / "livegs";
  return not_found(
      "state folder: neither XDG_STATE_HOME nor HOME is set; choose a folder with --state-dir DIR");
}

Result<void> make_state_folder(const std::filesystem::path& folder) {
  std::error_code error;
  if (std::filesystem::is_directory(folder, error)) return {};
  if (folder.has_parent_path()) std::filesystem::create_directories(folder.parent_path(), error);
  if (::mkdir(folder.c_str(), 0700) == 0 || errno == EEXIST) return {};
  return Error{ErrorCode::PermissionDenied, folder.string() + ": cannot be created: " + std::strerror(errno) +
                                                "; choose another folder with --state-dir DIR"};
}

Result<void> write_secret_file(const std::filesystem::path& path, std::string_view text) {
  if (auto made = make_state_folder(path.parent_path()); !made) return made;
  std::string pattern = path.string() + ".XXXXXX";
  const int file = ::mkostemp(pattern.data(), O_CLOEXEC);  // 0600
  if (file < 0) return file_error(path, "cannot be written");
  size_t done = 0;
  bool good = true;
  while (good && done < text.size()) {
    const ssize_t wrote = ::write(file, text.data() + done, text.size() - done);
    if (wrote < 0 && errno == EINTR) continue;
    good = wrote >= 0;
    if (good) done += static_cast<size_t>(wrote);
  }
  good = good && ::fsync(file) == 0 && ::rename(pattern.c_str(), path.c_str()) == 0;
  if (good) {
    ::close(file);
    return {};
  }
  Error error = file_error(path, "cannot be written");
  ::close(file);
  ::unlink(pattern.c_str());
  return error;
}

Result<std::string> read_secret_file(const std::filesystem::path& path) {
  struct stat about {};
  const bool found = ::stat(path.c_str(), &about) == 0;
  const bool given_by_root = found && about.st_uid == 0 && ::geteuid() != 0;
  if (found && (about.st_mode & (given_by_root ? 037 : 077)) != 0) {
    return Error{
        ErrorCode::PermissionDenied,
        path.string() +
            ": is readable by other users; create it again, or run chmod 600 if it was not disclosed"};
  }
  return read_text_file(path, kMaxSecretBytes);
}

}  // namespace livegs
