// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <vector>

#include "wire/little_endian.h"

// The list of fuzz targets of this program, and their common parts. A libFuzzer program has one,
// fuzz_replay_test all.

namespace livegs::fuzz {

using Bytes = std::vector<std::byte>;

struct Target {
  const char* name;
  // Reads one input. Any bytes are allowed; a wrong result ends the process by check().
  void (*look_at)(std::span<const std::byte> input);
  // First inputs, made by our own encoders. The same at each call.
  std::vector<Bytes> (*seeds)();
};

inline std::vector<Target>& targets() {
  static std::vector<Target> all;
  return all;
}
// Each target file calls it once, before main().
inline bool add_target(const Target& target) {
  targets().push_back(target);
  return true;
}

// Active in every build.
inline void check(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %s\n", what);
  std::abort();
}

// An input of several parts: each a u16 length, then its bytes. Any bytes are such an input; the last part
// may be short.
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
