// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace livegs {

// The floats that splats are summed in. 16-bit ones lose what a splat adds once it is less than 2^-12 of what
// is there, which costs some tenths of a per cent where a hundred splats lie in a pixel, more on a device
// that rounds towards zero, as lavapipe does. 32-bit ones are twice the memory traffic, which a device in
// software does not feel.
enum class BlendPrecision {
  Auto,  // Full for a device in software, else Half
  Half,
  Full,  // Half where the device cannot blend 32-bit floats
};

}  // namespace livegs
