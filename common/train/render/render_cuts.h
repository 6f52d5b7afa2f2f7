// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splat/project/projected_kernel.h"

namespace livegs {

// Cut-offs of the renderer. The picture is discontinuous at a cut-off, so the tests lower them to compare the
// gradient with central differences.
struct RenderCuts {
  float min_alpha = kMinAlpha;      // smaller contributions are skipped
  float min_transmittance = 1e-4f;  // a pixel stops before it falls under this
};

}  // namespace livegs
