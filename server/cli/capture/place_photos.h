// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "capture/capture.h"
#include "core/result.h"

namespace livegs {

// The folder that has the photos of `photos`: itself or images/ in it. NotFound if neither has a .jpg or
// .png.
Result<std::filesystem::path> photo_folder(const std::filesystem::path& photos);

// Finds the poses of photos by structure from motion: runs the program colmap on the CPU (extraction,
// matching of all pairs, mapping; Schönberger and Frahm 2016) in the folder `work` and reads its largest
// model. The frame and the unit are arbitrary. A model of an earlier run in `work` is used again. Notes name
// the photos that were not placed. Errors: colmap is missing or fails; fewer than half of the photos were
// placed.
Result<Capture> place_photos(const std::filesystem::path& photos, const std::filesystem::path& work);

}  // namespace livegs
