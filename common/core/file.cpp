// SPDX-License-Identifier: Apache-2.0
#include "core/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace livegs {
namespace {

struct Descriptor {
  int fd = -1;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
};

template <class Container>
Result<Container> read_whole(const std::filesystem::path& path, uint64_t max_bytes) {
  Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  if (file.fd < 0) {
    if (errno == ENOENT) return not_found(path.string() + ": no such file; check the path");
    return file_error(path, "cannot be opened");
  }
  struct stat status {};
  if (::fstat(file.fd, &status) != 0 || !S_ISREG(status.st_mode)) {
    return invalid_argument(path.string() + ": is not a regular file; give a file");
  }
  const auto size = static_cast<uint64_t>(status.st_size);
  if (size > max_bytes) {
    return Error{ErrorCode::TooLarge, path.string() + ": size is " + std::to_string(size) +
                                          " bytes and the limit " + std::to_string(max_bytes) +
                                          "; give a smaller file"};
  }
  Container content;
  content.resize(size);
  size_t done = 0;
  while (done < size) {
    const ssize_t got = ::read(file.fd, reinterpret_cast<char*>(content.data()) + done, size - done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return file_error(path, "cannot be read");
    if (got == 0) break;  // the file was truncated while it was read
    done += static_cast<size_t>(got);
  }
  content.resize(done);
  return content;
}

// Whether the path, its permissions or its disk must change. In other cases another machine or a later time
// may succeed.
bool of_user(int reason) {
  switch (reason) {
    case EACCES:
    case EPERM:
    case EROFS:
    case ENOENT:
    case EEXIST:
    case ENOTDIR:
    case EISDIR:
    case ENOTEMPTY:
    case ENAMETOOLONG:
    case ELOOP:
    case EFBIG:
    case EXDEV:
      return true;
    default:
      return false;
  }
}

const char* remedy_of(int reason) {
  switch (reason) {
    case ENOSPC:
    case EDQUOT:
      return "free space on its disk";
    case EIO:
      return "check its disk";
    case EACCES:
    case EPERM:
      return "change the permissions, or give another path";
    case EROFS:
      return "give a path on another disk";
    case EEXIST:
    case ENOTDIR:
      return "give a path that does not lead through a file";
    case EISDIR:
      return "give the name of a file";
    case ENOTEMPTY:
      return "give an empty folder";
    case EXDEV:
      return "give a path on the same disk";
    case ENAMETOOLONG:
      return "give a shorter name";
    case EFBIG:
      return "raise the limit of file sizes (ulimit -f)";
    case EMFILE:
    case ENFILE:
      return "raise the limit of open files (ulimit -n)";
    default:
      return "check the path";
  }
}

}  // namespace

Error file_error(const std::filesystem::path& path, std::string_view problem, std::error_code reason) {
  const int number = reason.value();
  return {
      of_user(number) ? ErrorCode::PermissionDenied : ErrorCode::Internal,
      path.string() + ": " + std::string(problem) + ": " + std::strerror(number) + "; " + remedy_of(number)};
}

Error file_error(const std::filesystem::path& path, std::string_view problem) {
  return file_error(path, problem, {errno, std::generic_category()});
}

Result<std::vector<std::byte>> read_file(const std::filesystem::path& path, uint64_t max_bytes) {
  return read_whole<std::vector<std::byte>>(path, max_bytes);
}

Result<std::string> read_text_file(const std::filesystem::path& path, uint64_t max_bytes) {
  return read_whole<std::string>(path, max_bytes);
}

Result<void> write_file_atomically(const std::filesystem::path& path, std::span<const std::byte> bytes,
                                   const WriteStep& before) {
  const auto step = [&](const char* name) {
    if (before) before(name);
  };
  std::string pattern = path.string() + ".XXXXXX";
  step("create");
  Descriptor file{::mkostemp(pattern.data(), O_CLOEXEC)};
  if (file.fd < 0) return file_error(path, "cannot be written");
  const auto fail = [&] {
    Error error = file_error(path, "cannot be written");
    ::unlink(pattern.c_str());
    return error;
  };
  size_t done = 0;
  while (done < bytes.size()) {
    step("write");
    const ssize_t wrote = ::write(file.fd, bytes.data() + done, bytes.size() - done);
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote < 0) return fail();
    done += static_cast<size_t>(wrote);
  }
  step("sync");
  if (::fchmod(file.fd, 0644) != 0 || ::fsync(file.fd) != 0) return fail();
  step("rename");
  if (::rename(pattern.c_str(), path.c_str()) != 0) return fail();
  step("sync folder");
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  const Descriptor names{::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
  // Some file systems cannot sync a folder; the file itself is already synced.
  if (names.fd >= 0) (void)::fsync(names.fd);
  return {};
}

Result<void> write_file_atomically(const std::filesystem::path& path, std::string_view text,
                                   const WriteStep& before) {
  return write_file_atomically(path, std::as_bytes(std::span(text.data(), text.size())), before);
}

}  // namespace livegs
