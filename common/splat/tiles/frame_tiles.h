// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "compute/buffer.h"
#include "splat/image.h"
#include "splat/raster/frame_splats.h"
#include "splat/tiles/tile_pairs.h"

namespace livegs {

// Pictures of a sorted frame by compute passes alone: the kernels of each tile of 16 x 16 pixels, nearest
// first, blended with an end at opaque pixels (Kerbl et al. 2023, section 6). For devices whose draw is
// slower or that cannot draw. Sorting pairs of tile and kernel by tile keeps the draw order of the frame.
//
// Takes the buffers of the pairs and 4 bytes per pixel, or 16 for pictures of floats. One thread.
class FrameTiles {
 public:
  struct Options {
    bool floats = false;     // premultiplied colour and coverage, without background and rounding
    uint32_t max_pairs = 0;  // 0: the limit of the device
  };
  FrameTiles(Backend& backend, const Options& options);

  // Records the pairs of tiles and kernels of a frame, which must be sorted, in the order of the tiles. All
  // eyes of the frame have this size, in px. `frame` is used until finish().
  Result<void> bin(const FrameSplats& frame, int width, int height, int eyes);
  // Records the blending of the binned frame. `background`: display-encoded.
  Result<void> blend(const Eigen::Vector3f& background);

  // Runs all recorded passes. If the frame has more pairs than the buffers hold, they grow, and it is binned
  // and blended again. TooLarge if the device holds no buffers for them.
  Result<void> finish();
  // The same, and reads one image per eye.
  Result<void> finish(std::vector<Image>& images);

  // Pixels of the eyes, row by row, after kTileHeaderWords: RGBA with 8 bits each, or four floats.
  BufferId picture() const { return picture_.id(); }

 private:
  size_t picture_words() const;
  // Reads the start of a picture that has all its pairs.
  Result<void> read_complete(std::span<uint32_t> words);

  Backend* backend_;
  Options options_;
  const FrameSplats* frame_ = nullptr;
  Eigen::Vector3f background_{0, 0, 0};
  int width_ = 0, height_ = 0, eyes_ = 0;
  TilePairs pairs_;
  Buffer picture_;
};

}  // namespace livegs
