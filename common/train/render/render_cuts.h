// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splat/project/projected_kernel.h"

namespace livegs {

// Cut-offs of the renderer. They make the picture jump, so central differences agree with the gradient only
// if they are lowered (tests).
struct RenderCuts {
  float min_alpha = kMinAlpha;      // smaller contributions are skipped
  float min_transmittance = 1e-4f;  // a pixel stops before it falls under this
};

}  // namespace livegs
