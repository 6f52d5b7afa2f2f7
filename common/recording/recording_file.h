// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include "core/result.h"

namespace livegs {

// A file on disk that is appended to or read at any place. Errors name it. One thread.
class RecordingFile {
 public:
  // A new one: InvalidArgument when something has that name already, or the folder cannot be written.
  static Result<RecordingFile> create(const std::filesystem::path& path);
  static Result<RecordingFile> open(const std::filesystem::path& path);
  RecordingFile(RecordingFile&& other) noexcept;
  RecordingFile& operator=(RecordingFile&& other) noexcept;
  ~RecordingFile();

  const std::filesystem::path& path() const { return path_; }
  uint64_t size() const { return size_; }
  // All of the bytes, or none: what a full disk took of them is cut off again.
  Result<void> append(std::span<const std::byte> bytes);
  // As many bytes as `bytes` holds; InvalidData where the file ends before.
  Result<void> read(uint64_t offset, std::span<std::byte> bytes) const;
  // A file that grows has more now.
  void look_again();

 private:
  RecordingFile(std::filesystem::path path, int descriptor);
  std::filesystem::path path_;
  int descriptor_;
  uint64_t size_ = 0;
};

}  // namespace livegs
