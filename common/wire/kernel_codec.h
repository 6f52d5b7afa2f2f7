// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/result.h"
#include "gaussian/posed_kernels.h"

// Codec of posed kernels, for clients that cannot skin, and as the baseline of the savings of driver streams.
// See proto/frame_format.md, "Kernels". Each frame is self-contained.

namespace livegs {

struct ObjectKernels {
  uint32_t object_id = 0;
  uint32_t revision = 0;  // of the asset, at most 255: as ObjectDrivers::revision
  PosedKernels kernels;   // arrays of equal length
};
struct KernelFrame {
  uint64_t tick = 0;
  int64_t simulated_ns = 0;
  std::vector<ObjectKernels> objects;
};

enum class KernelEncoding : uint8_t {
  Exact = 0,  // floats, 52 bytes per kernel; lossless
  // 20 bytes: 16 bits per axis in the box of the object, deviations within 0.9 %, rotations within 0.07
  // degrees
  Quantised = 1,
};

// Preconditions: finite values; covariances are symmetric and not negative; rotations are not zero; the
// result is at most kMaxFrameBytes. Quantised: standard deviations are clamped to 1 µm to 16 m.
std::vector<std::byte> encode_kernels(const KernelFrame& frame, KernelEncoding encoding);

// Maximum bytes of one object with this number of kernels; and of a frame without objects.
size_t kernel_bytes(size_t kernels, KernelEncoding encoding);
inline constexpr size_t kKernelFrameHeaderBytes = 24;

// Accepts any bytes. Quantised kernels can always be drawn; exact ones are only checked to be finite. Memory
// is bounded by the size of the input.
Result<KernelFrame> decode_kernels(std::span<const std::byte> bytes);

}  // namespace livegs
