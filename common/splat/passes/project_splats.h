// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compute/pass.h"
#include "splat/camera.h"
#include "splat/passes/project_splats_layout.h"

namespace livegs {

// The pass that culls, projects and shades kernels for one eye or two, and writes the keys they are sorted
// by: what project_kernel does, in floats, with half-float bands. An item is a kernel. Buffers: FrameViews,
// PosedKernelRow, KernelLookRow, bands (words), SplatRow of the first eye, SplatRow of the second (unused
// with one eye), keys (kSortDroppedKey where no eye sees the kernel).
//
// Two products need more than float arithmetic has: the cofactors of a needle's covariance, and the
// determinant of its ellipse. Both are formed without cancellation (precise.h), so that a needle keeps its
// width.
const Pass& project_splats_pass();

// max_radius_px > 0: an ellipse that reaches further is shrunk as a whole until it reaches that far, low-pass
// included, so that a kernel before the eye does not cover the screen. 0: none is.
// min_contribution_px > 0: a kernel that adds less to the picture is left out of it. What it adds at most is
// its opacity summed over the pixels, opacity * 2 pi sqrt(det) of its ellipse, of a kernel that nothing
// covers. Each eye decides for itself. 0: none is left out.
EyeView eye_view(const Camera& camera, float max_radius_px, float min_contribution_px = 0);

}  // namespace livegs
