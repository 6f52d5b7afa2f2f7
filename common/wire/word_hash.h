// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace livegs {

// Hash of a sequence of 64-bit words (constants of splitmix64). See proto/frame_format.md, "Frame". It
// detects different states; it is not cryptographic.
class WordHash {
 public:
  void add(uint64_t word) {
    state_ = (state_ ^ word) * 0xBF58476D1CE4E5B9u;
    state_ ^= state_ >> 29;
  }
  uint32_t value() const { return static_cast<uint32_t>(state_ >> 16); }

 private:
  uint64_t state_ = 0x9E3779B97F4A7C15u;
};

}  // namespace livegs
