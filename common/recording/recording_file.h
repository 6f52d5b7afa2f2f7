// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include "core/result.h"

namespace livegs {

// A file on disk with append and random-access reads. Errors contain its name. One thread.
class RecordingFile {
 public:
  // Creates a new file. InvalidArgument if the name already exists or the folder cannot be written.
  static Result<RecordingFile> create(const std::filesystem::path& path);
  static Result<RecordingFile> open(const std::filesystem::path& path);
  RecordingFile(RecordingFile&& other) noexcept;
  RecordingFile& operator=(RecordingFile&& other) noexcept;
  ~RecordingFile();

  const std::filesystem::path& path() const { return path_; }
  uint64_t size() const { return size_; }
  // Appends all bytes or none: a partial write on a full disk is truncated again.
  Result<void> append(std::span<const std::byte> bytes);
  // Reads bytes.size() bytes. InvalidData if the file ends before.
  Result<void> read(uint64_t offset, std::span<std::byte> bytes) const;
  // Updates the size of a file that is still being written.
  void look_again();

 private:
  RecordingFile(std::filesystem::path path, int descriptor);
  std::filesystem::path path_;
  int descriptor_;
  uint64_t size_ = 0;
};

}  // namespace livegs
