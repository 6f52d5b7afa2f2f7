// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/division/picture_votes.h"
#include "splat/image.h"

namespace livegs {

// The kernels that a picture shows, in the colours of their parts (part_rgb) and shaded by their own
// brightness, over white; in the size of the sights. In its own grey if the object is not divided.
Image part_picture(const PictureSights& sights, const SurfaceKernels& kernels, const MaterialParts& parts);

}  // namespace livegs
