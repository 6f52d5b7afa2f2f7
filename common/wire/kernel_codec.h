// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/result.h"
#include "gaussian/posed_kernels.h"

// Kernels themselves as bytes, for a client that cannot skin and as the yardstick of what drivers save;
// proto/frame_format.md, "Kernels". Self-contained: each frame is read without any before it.

namespace livegs {

struct ObjectKernels {
  uint32_t object_id = 0;
  uint32_t revision = 0;  // of the asset they are of, to 255: as ObjectDrivers has it
  PosedKernels kernels;   // arrays of one length
};
struct KernelFrame {
  uint64_t tick = 0;
  int64_t simulated_ns = 0;
  std::vector<ObjectKernels> objects;
};

enum class KernelEncoding : uint8_t {
  Exact = 0,      // floats, 52 bytes a kernel: what is decoded has the bits of what was encoded
  Quantised = 1,  // 20 bytes: 16 bits an axis in the object's box, deviations within 0.9 %, rotations within
                  // 0.07 degrees
};

// Preconditions: finite values; covariances are symmetric and not negative, rotations are not zero;
// quantised, standard deviations lie in 1 µm ... 16 m (others become the nearer of the two); no more than
// kMaxFrameBytes come of it.
std::vector<std::byte> encode_kernels(const KernelFrame& frame, KernelEncoding encoding);

// What an object of so many kernels takes of a frame, at most; and a frame without any.
size_t kernel_bytes(size_t kernels, KernelEncoding encoding);
inline constexpr size_t kKernelFrameHeaderBytes = 24;

// Accepts any bytes. What comes of quantised ones can be drawn, whatever they say; exact ones are finite and
// no more. Memory is bounded by the input's size.
Result<KernelFrame> decode_kernels(std::span<const std::byte> bytes);

}  // namespace livegs
