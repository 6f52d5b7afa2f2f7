// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace livegs {

// Precision of blending. 16-bit floats lose contributions below 2^-12 of the sum, an error of some tenths of
// a percent at a hundred splats per pixel, and more on devices that round towards zero, such as lavapipe.
// 32-bit floats need twice the memory bandwidth, which does not matter for a software device.
enum class BlendPrecision {
  Auto,  // Full for a software device, else Half
  Half,
  Full,  // Half if the device cannot blend 32-bit floats
};

}  // namespace livegs
