// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <vector>

#include "wire/little_endian.h"

// What each fuzz target says of itself, and what targets have in common. libFuzzer owns main().

namespace livegs::fuzz {

using Bytes = std::vector<std::byte>;

// Looks at one input. Any bytes are fine; an answer that is wrong ends the process by check().
void look_at(std::span<const std::byte> input);
// Inputs to begin with, made by our own encoders. The same each time.
std::vector<Bytes> seeds();

// Counts in every build.
inline void check(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %s\n", what);
  std::abort();
}

// An input of several parts: each a u16 length, then its bytes. Any bytes are such an input; the last part may be short.
inline std::vector<std::span<const std::byte>> parts_of(std::span<const std::byte> input) {
  std::vector<std::span<const std::byte>> parts;
  while (input.size() >= 2) {
    const size_t length = std::to_integer<size_t>(input[0]) | std::to_integer<size_t>(input[1]) << 8;
    input = input.subspan(2);
    parts.push_back(input.first(std::min(length, input.size())));
    input = input.subspan(parts.back().size());
  }
  return parts;
}
inline Bytes joined(const std::vector<Bytes>& parts) {
  ByteWriter out;
  for (const Bytes& part : parts) {
    check(part.size() < 65536, "a seed's part is under 64 kB");
    out.write(static_cast<uint16_t>(part.size()));
    for (const std::byte byte : part) out.write(std::to_integer<uint8_t>(byte));
  }
  return std::move(out).take();
}

}  // namespace livegs::fuzz
