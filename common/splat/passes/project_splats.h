// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compute/pass.h"
#include "splat/camera.h"
#include "splat/passes/project_splats_layout.h"

namespace livegs {

// The pass that culls, projects and shades kernels for one eye or two and writes their sort keys:
// project_kernel in floats, with half-float bands. One item per kernel. Buffers: FrameViews, PosedKernelRow,
// KernelLookRow, bands (words), SplatRow of the first eye, SplatRow of the second (unused with one eye), keys
// (kSortDroppedKey if no eye sees the kernel), the words of a ShadowTable, at least kShadowHeaderWords.
//
// Two quantities need more precision than float arithmetic: the cofactors of a needle's covariance and the
// determinant of its ellipse. Both are computed without cancellation (precise.h), so that a needle keeps its
// width.
const Pass& project_splats_pass();

// `max_radius_px` > 0: larger ellipses are shrunk uniformly to this radius, low-pass included, so that a
// kernel close to the eye does not cover the screen. 0: no limit.
// `min_contribution_px` > 0: kernels with a smaller contribution are culled, for each eye separately. The
// contribution is an upper bound, the opacity summed over the pixels without occlusion: opacity * 2 pi
// sqrt(det) of the ellipse. 0: none are culled.
EyeView eye_view(const Camera& camera, float max_radius_px, float min_contribution_px = 0);

}  // namespace livegs
