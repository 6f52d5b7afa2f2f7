// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <vector>

#include "wire/little_endian.h"

// The list of fuzz targets of a program, and their common functions. A libFuzzer program has one target;
// fuzz_replay_test has all of them.

namespace livegs::fuzz {

using Bytes = std::vector<std::byte>;

struct Target {
  const char* name;
  // Decodes one input. All byte sequences are allowed; check() ends the process on a wrong result.
  void (*look_at)(std::span<const std::byte> input);
  // Initial inputs, made with the project's encoders. The same at each call.
  std::vector<Bytes> (*seeds)();
};

inline std::vector<Target>& targets() {
  static std::vector<Target> all;
  return all;
}
// Called once in each target file, before main().
inline bool add_target(const Target& target) {
  targets().push_back(target);
  return true;
}

// Ends the process unless the condition is true. Active in every build type.
inline void check(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "check failed: %s\n", what);
  std::abort();
}

// Splits an input into parts: each is a u16 length, then that number of bytes. Every byte sequence is valid;
// the last part may be short.
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
    check(part.size() < 65536, "a part of a seed is shorter than 64 KiB");
    out.write(static_cast<uint16_t>(part.size()));
    for (const std::byte byte : part) out.write(std::to_integer<uint8_t>(byte));
  }
  return std::move(out).take();
}

}  // namespace livegs::fuzz
