// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace livegs {

// Arguments of the CPU function of a pass for one dispatch. Buffers are in the order of the shader bindings
// and aligned to 16 bytes.
struct PassArguments {
  std::span<const std::span<std::byte>> buffers;
  std::span<const std::byte> constants;
};

// One data-parallel step as a value: a CPU function, which is the reference, and a compute shader that does
// the same. A pass and the data it points to live as long as the program.
//
// Shader interface: buffers are std430 storage buffers of set 0, bindings 0, 1, ...; constants are the push
// constant block; the group size along x is specialization constant 0. The shader runs for `count` items
// rounded up to whole groups, so it must skip items past the end, using a count in its constants.
// rounded up to whole groups, so it guards against items past the end by a count among its constants.
struct Pass {
  std::string_view name;         // name of shader, debug label and test; unique
  uint32_t group_size = 0;       // invocations per group, 1..256
  uint32_t buffer_count = 0;     // 1..kMaxPassBuffers
  uint32_t constants_bytes = 0;  // a multiple of 4, up to kMaxPassConstantsBytes
  std::span<const uint32_t> spirv;
  // Processes items [begin, end), on any thread. `begin` is a multiple of kMaxPassGroupSize, so groups of a
  // power of two are never split.
  void (*run)(const PassArguments& arguments, size_t begin, size_t end) = nullptr;
};

// Required device limits. Vulkan 1.3 guarantees 128 bytes of constants, but only 4 buffers and 128
// invocations; 8 and 256 are also the WebGPU requirements for the same hardware.
inline constexpr uint32_t kMaxPassBuffers = 8;
inline constexpr uint32_t kMaxPassConstantsBytes = 128;
inline constexpr uint32_t kMaxPassGroupSize = 256;

}  // namespace livegs
