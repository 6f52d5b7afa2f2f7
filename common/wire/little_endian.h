// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

// Converts numbers to little-endian bytes and back, on machines of any byte order.

namespace livegs {

class ByteWriter {
 public:
  // Writes the lowest `width` bytes of `value`.
  void write_bits(uint64_t value, size_t width) {
    for (size_t i = 0; i < width; ++i) bytes_.push_back(static_cast<std::byte>(value >> (8 * i)));
  }
  template <std::integral T>
  void write(T value) {
    write_bits(static_cast<uint64_t>(value), sizeof(T));
  }
  void write(float value) { write(std::bit_cast<uint32_t>(value)); }
  void write(double value) { write(std::bit_cast<uint64_t>(value)); }

  void reserve(size_t count) { bytes_.reserve(count); }
  std::vector<std::byte> take() && { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

// Reading past the end returns zeros and sets the failed state permanently, so callers may check once per
// section.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  uint64_t read_bits(size_t width) {
    if (width > remaining()) {
      failed_ = true;
      offset_ = bytes_.size();
      return 0;
    }
    uint64_t value = 0;
    for (size_t i = 0; i < width; ++i) value |= std::to_integer<uint64_t>(bytes_[offset_ + i]) << (8 * i);
    offset_ += width;
    return value;
  }
  template <std::integral T>
  T read() {
    return static_cast<T>(read_bits(sizeof(T)));
  }
  template <std::same_as<float> T>
  T read() {
    return std::bit_cast<float>(read<uint32_t>());
  }
  template <std::same_as<double> T>
  T read() {
    return std::bit_cast<double>(read<uint64_t>());
  }

  // Skips `count` bytes, with the same checks as reading them.
  void skip(size_t count) {
    failed_ = failed_ || count > remaining();
    offset_ = count > remaining() ? bytes_.size() : offset_ + count;
  }

  bool failed() const { return failed_; }
  size_t offset() const { return offset_; }
  size_t remaining() const { return bytes_.size() - offset_; }

 private:
  std::span<const std::byte> bytes_;
  size_t offset_ = 0;
  bool failed_ = false;
};

}  // namespace livegs
