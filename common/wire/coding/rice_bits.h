// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

// Rice codes in a bit stream, lowest bit of a byte first. Layout: proto/frame_format.md, "Bits". Writer and
// reader have the same interface, so each coder is written once: code() takes the value to write and returns
// the value read.

namespace livegs {

inline constexpr int kMaxZeros = 24;  // of a code; then 32 raw bits follow
inline constexpr int kMaxRiceBits = 24;

inline uint64_t little_endian(uint64_t word) {
  return std::endian::native == std::endian::little ? word : __builtin_bswap64(word);
}

// Writer and reader keep their state in registers over memory owned by others. Loops work on a copy and store
// it back at the end; otherwise the compiler must assume that the written memory aliases the object.
class RiceWriter {
 public:
  static constexpr bool kReads = false;
  // Allocates room for at most `max_codes` codes or bit strings.
  RiceWriter(std::vector<std::byte>& buffer, size_t max_codes) {
    if (buffer.size() < 7 * max_codes + 16) buffer.resize(7 * max_codes + 16);
    begin_ = at_ = buffer.data();
  }
  uint32_t code(uint32_t value, int k) {
    const uint32_t zeros = value >> k;
    if (zeros < kMaxZeros) {
      put((uint64_t{value & ((uint32_t{1} << k) - 1)} << 1 | 1) << zeros, static_cast<int>(zeros) + 1 + k);
    } else {
      put(uint64_t{value} << kMaxZeros, kMaxZeros + 32);
    }
    return value;
  }
  // Same as three calls of code(), in one bit string if it fits.
  void three(const std::array<uint32_t, 3>& values, int k) {
    const std::array<uint32_t, 3> zeros = {values[0] >> k, values[1] >> k, values[2] >> k};
    const uint32_t count = zeros[0] + zeros[1] + zeros[2] + 3 * (static_cast<uint32_t>(k) + 1);
    if ((zeros[0] | zeros[1] | zeros[2]) >= kMaxZeros || count > kMaxBits) {
      for (const uint32_t value : values) code(value, k);
      return;
    }
    const uint32_t mask = (uint32_t{1} << k) - 1;
    uint64_t word = 0;
    for (size_t i = 3; i-- > 0;) word = ((word << k | (values[i] & mask)) << 1 | 1) << zeros[i];
    put(word, static_cast<int>(count));
  }
  // 1 to 32 bits.
  uint32_t bits(uint32_t value, int count) {
    put(value, count);
    return value;
  }
  std::span<const std::byte> written() const {
    return {begin_, static_cast<size_t>(at_ - begin_) + (count_ > 0 ? 1u : 0u)};
  }

 private:
  static constexpr uint32_t kMaxBits = 56;

  void put(uint64_t value, int count) {
    waiting_ |= value << count_;
    count_ += count;
    const uint64_t word = little_endian(waiting_);
    std::memcpy(at_, &word, 8);
    at_ += count_ >> 3;
    waiting_ >>= count_ & ~7;  // 56 at most: 7 bits were pending, and a code has at most kMaxBits
    count_ &= 7;
  }

  std::byte *begin_ = nullptr, *at_ = nullptr;
  uint64_t waiting_ = 0;  // fewer than 8 pending bits between calls
  int count_ = 0;
};

// Reads zeros past the end. Callers must check failed() before using values, at least once per driver: only
// kSlack bytes are padded after the end.
class RiceReader {
 public:
  static constexpr bool kReads = true;
  static constexpr size_t kSlack = 128;  // some 16 codes of 56 bits
  RiceReader(std::vector<std::byte>& buffer, std::span<const std::byte> bytes) : end_(8 * bytes.size()) {
    if (buffer.size() < bytes.size() + kSlack) buffer.resize(bytes.size() + kSlack);
    std::copy(bytes.begin(), bytes.end(), buffer.begin());
    std::fill_n(buffer.begin() + static_cast<std::ptrdiff_t>(bytes.size()), kSlack, std::byte{0});
    data_ = buffer.data();
  }
  uint32_t code(uint32_t, int k) {
    const uint64_t word = peek();
    const int zeros = std::countr_zero(word | uint64_t{1} << kMaxZeros);
    if (zeros == kMaxZeros) {
      at_ += kMaxZeros + 32;
      return static_cast<uint32_t>(word >> kMaxZeros);
    }
    at_ += static_cast<uint64_t>(zeros + 1 + k);
    return static_cast<uint32_t>(zeros) << k |
           (static_cast<uint32_t>(word >> (zeros + 1)) & ((uint32_t{1} << k) - 1));
  }
  // Same as three calls of code(), from a single load while the bits suffice.
  void three(std::array<uint32_t, 3>& values, int k) {
    uint64_t word = peek();
    const uint32_t mask = (uint32_t{1} << k) - 1;
    int left = 57;
    size_t i = 0;
    for (; i < 3; ++i) {
      const int zeros = std::countr_zero(word | uint64_t{1} << kMaxZeros), used = zeros + 1 + k;
      if (zeros == kMaxZeros || used > left) break;
      values[i] = static_cast<uint32_t>(zeros) << k | (static_cast<uint32_t>(word >> (zeros + 1)) & mask);
      word >>= used;
      left -= used;
    }
    at_ += static_cast<uint64_t>(57 - left);
    for (; i < 3; ++i) values[i] = code(0, k);
  }
  uint32_t bits(uint32_t, int count) {
    const uint64_t word = peek();
    at_ += static_cast<uint64_t>(count);
    return static_cast<uint32_t>(word & ((uint64_t{1} << count) - 1));
  }
  bool failed() const { return at_ > end_; }
  uint64_t remaining_bits() const { return end_ - std::min(end_, at_); }
  // Whether the remaining bits are fewer than 8 and all 0.
  bool at_end() const {
    return at_ <= end_ && end_ - at_ < 8 &&
           (at_ == end_ || std::to_integer<unsigned>(data_[at_ / 8]) >> (at_ % 8) == 0);
  }

 private:
  uint64_t peek() const {  // at least 57 bits
    uint64_t word;
    std::memcpy(&word, data_ + at_ / 8, 8);
    return little_endian(word) >> (at_ % 8);
  }

  const std::byte* data_ = nullptr;
  uint64_t at_ = 0, end_ = 0;  // bits
};

// Running mean of the magnitude of one class of integers. Both ends update it in the same way.
class RiceScale {
 public:
  static constexpr int kMeanShift = 5;
  // `expected`: initial sum of the magnitudes of three integers, the quantity passed to add().
  explicit RiceScale(uint32_t expected = 64) : mean_(expected << kMeanShift) { choose(); }
  // Rice parameter for the zigzag of such an integer.
  int k() const { return k_; }
  void add(uint32_t sum) {
    mean_ += sum - (mean_ >> kMeanShift);
    choose();
  }

 private:
  void choose() {
    k_ = std::min(kMaxRiceBits, static_cast<int>(std::bit_width((mean_ - (mean_ > 0)) >> (kMeanShift + 1))));
  }

  uint32_t mean_;  // times 2^kMeanShift
  int k_;
};

}  // namespace livegs
