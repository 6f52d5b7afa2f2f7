// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "gaussian/asset/bytes.h"
#include "gaussian/asset_frame.h"

namespace livegs {

// Maps three bytes of a pixel to three values: by a table or, in version 1, as fractions between bounds.
struct SogScale {
  std::vector<float> codebook;     // 256 values, or none
  std::array<float, 4> mins = {};  // the fourth is only used by sh0 of version 1: its opacity logit
  std::array<float, 4> maxs = {};
  std::string file;
};

struct SogPalette {
  size_t count = 0;
  int degree = 0;  // called "bands" in the file
  std::vector<float> codebook;
  std::string centroids_file, labels_file;
};

// The checked content of meta.json: all required numbers exist and are finite.
struct SogMeta {
  int version = 2;
  size_t count = 0;
  bool antialiased = false;
  std::array<float, 3> means_min = {}, means_max = {};
  std::string means_low_file, means_high_file, quats_file;
  SogScale scales, sh0;
  std::optional<SogPalette> palette;
  AssetFrame frame;                // from the member "livegs": a list of the lines of asset_frame.h
  std::vector<std::string> notes;  // lines that are not understood
};

Result<SogMeta> parse_sog_meta(Bytes json, std::string_view name);

}  // namespace livegs
