// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace livegs {

// What the CPU twin of a pass sees of one dispatch. Buffers are bound in the order of the shader's bindings
// and aligned to 16 bytes.
struct PassArguments {
  std::span<const std::span<std::byte>> buffers;
  std::span<const std::byte> constants;
};

// One data-parallel step, as a value: a CPU function, which is the reference, beside a compute shader that
// does the same. A pass lives as long as the program, as does what it points at.
//
// The shader takes its buffers as std430 storage buffers of set 0, bindings 0, 1, ...; its constants as the
// push constant block; and its group size as specialization constant 0, along x. It runs for `count` items
// rounded up to whole groups, so it guards against items past the end by a count among its constants.
struct Pass {
  std::string_view name;         // one string for shader, debug label and test; unique
  uint32_t group_size = 0;       // invocations a group, 1..256
  uint32_t buffer_count = 0;     // 1..kMaxPassBuffers
  uint32_t constants_bytes = 0;  // a multiple of 4, up to kMaxPassConstantsBytes
  std::span<const uint32_t> spirv;
  // Items [begin, end), on any thread; begin is a multiple of kMaxPassGroupSize, so that no group of a power
  // of two is divided.
  void (*run)(const PassArguments& arguments, size_t begin, size_t end) = nullptr;
};

// What a device must have to be used. Vulkan 1.3 itself demands the 128 bytes, but only 4 buffers and 128
// invocations; 8 and 256 are what WebGPU asks of the same hardware.
inline constexpr uint32_t kMaxPassBuffers = 8;
inline constexpr uint32_t kMaxPassConstantsBytes = 128;
inline constexpr uint32_t kMaxPassGroupSize = 256;

}  // namespace livegs
