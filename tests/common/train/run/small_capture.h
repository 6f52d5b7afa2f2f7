// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "capture/capture.h"

namespace livegs {

struct SmallCapture {
  size_t views = 10;
  int width = 64, height = 48;
  size_t kernels = 200;
  bool transparent = false;  // photos with alpha, without a background
  bool floor = false;        // an opaque floor of small kernels, seen from above, instead of a cloud
};
// Draws coloured kernels from cameras around it with the product's rasteriser, and writes the
// photos, transforms.json and a points file into the folder.
void write_small_capture(const std::filesystem::path& folder, const SmallCapture& options = {});

}  // namespace livegs
