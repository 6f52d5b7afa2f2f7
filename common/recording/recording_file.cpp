// SPDX-License-Identifier: Apache-2.0
#include "recording/recording_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace livegs {

RecordingFile::RecordingFile(std::filesystem::path path, int descriptor)
    : path_(std::move(path)), descriptor_(descriptor) {
  look_again();
}

RecordingFile::RecordingFile(RecordingFile&& other) noexcept
    : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)), size_(other.size_) {}

RecordingFile& RecordingFile::operator=(RecordingFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(size_, other.size_);
  return *this;
}

RecordingFile::~RecordingFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<RecordingFile> RecordingFile::create(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (descriptor < 0) {
    const std::string why = errno == EEXIST ? "already exists; choose another name for the recording"
                                            : std::string("cannot be created: ") + std::strerror(errno) +
                                                  "; choose another folder";
    return invalid_argument(path.string() + ": " + why);
  }
  return RecordingFile(path, descriptor);
}

Result<RecordingFile> RecordingFile::open(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) {
    return Error{
        errno == ENOENT ? ErrorCode::NotFound : ErrorCode::InvalidArgument,
        path.string() + ": cannot be read: " + std::strerror(errno) + "; check the path and its permissions"};
  }
  struct stat about {};
  RecordingFile file(path, descriptor);
  if (::fstat(descriptor, &about) != 0 || !S_ISREG(about.st_mode))
    return invalid_argument(path.string() + ": is not a regular file; give a *.lvgrec file");
  return file;
}

void RecordingFile::look_again() {
  struct stat about {};
  if (::fstat(descriptor_, &about) == 0) size_ = static_cast<uint64_t>(about.st_size);
}

Result<void> RecordingFile::append(std::span<const std::byte> bytes) {
  uint64_t at = size_;
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(at));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      const Error error{ErrorCode::Internal,
                        path_.string() + ": cannot be written: " +
                            (written < 0 ? std::strerror(errno) : "no bytes were written")};
      if (at > size_ && ::ftruncate(descriptor_, static_cast<off_t>(size_)) != 0) {
        // A reader stops before the incomplete chunk.
      }
      return error;
    }
    at += static_cast<uint64_t>(written);
    bytes = bytes.subspan(static_cast<size_t>(written));
  }
  size_ = at;
  return {};
}

Result<void> RecordingFile::read(uint64_t offset, std::span<std::byte> bytes) const {
  while (!bytes.empty()) {
    const ssize_t got = ::pread(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0)
      return Error{ErrorCode::Internal,
                   path_.string() + ": cannot be read: " + std::strerror(errno) + "; restore it from a copy"};
    if (got == 0) return invalid_data(path_.string() + ": is truncated; copy the recording again");
    offset += static_cast<uint64_t>(got);
    bytes = bytes.subspan(static_cast<size_t>(got));
  }
  return {};
}

}  // namespace livegs
