// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "capture/capture.h"
#include "core/result.h"
#include "gaussian/gaussian_asset.h"

namespace livegs {

// Known length of the longest side of a thing. Things are numbered from 1.
struct KnownLength {
  size_t thing = 1;
  double longest_side_m = 0;
};
// Reads "part_03=0.21".
Result<KnownLength> read_known_length(const std::string& text);

struct SegmentRequest {
  std::string name;                   // of the room, for messages
  std::vector<CapturedView> cameras;  // of the photos; empty: views are chosen
  std::filesystem::path masks;        // folder of label pictures; empty: none
  std::string up;                     // axis of the asset, as in a scene file; empty: of the cameras, else -y
  double scale = 1.0;                 // metres per unit of the asset
  std::optional<KnownLength> known;   // instead of `scale`
  std::filesystem::path output;  // a folder, see check_segment_folder(); files of the same names are replaced
  // Called after each view and each step of the work with the part that is done, 0 to 1; may be empty.
  std::function<void(double done)> progress;
};
struct SegmentOutcome {
  size_t things = 0;
  double scale = 1.0;
};

// Checks that `output` is a new or an empty folder.
Result<void> check_segment_folder(const std::filesystem::path& output);

// Finds the things of a room, prints a line for each, and writes the folder (segment_files.h). After an
// error, nothing is written. A room without things is an error.
Result<SegmentOutcome> segment_room(GaussianAsset asset, const SegmentRequest& request);

}  // namespace livegs
