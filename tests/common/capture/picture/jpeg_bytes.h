// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "splat/image.h"

namespace livegs {

// A JPEG file of quality 98. `orientation` 0: no EXIF block.
std::vector<std::byte> encode_jpeg(const Image& image, int orientation);

}  // namespace livegs
