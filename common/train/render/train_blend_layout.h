// SPDX-License-Identifier: Apache-2.0

// Data of the passes train_blend, train_backward and train_gather. Shared by C++ and GLSL.

#ifdef __cplusplus
#pragma once
#include <cstdint>
namespace livegs {
using uint = uint32_t;
#endif

const uint kTrainGroup = 256;      // invocations per group: the pixels of a tile
const uint kTrainHeaderWords = 8;  // before the pixels of a picture: the number of pairs; the rest is unused
const uint kTrainNone = 0xffffffffu;

// A pixel after all kernels.
struct TrainPixel {
  uint halfway;  // rank of the kernel at which transmittance falls under a half; kTrainNone: none
  float red;     // without background
  float green;
  float blue;
  float through;    // transmittance
  float depth_sum;  // of weight times depth, scene units
  float spread;     // as in TilePixels, scene units
  uint unused;
};

struct TrainPixelGradient {
  float red;
  float green;
  float blue;
  float alpha;
  float spread;
};

// EllipseGradient of a pair or of a kernel.
struct TrainEllipseGradient {
  float sum;
  float x;
  float y;
  float xx;
  float xy;
  float yy;
  float red;
  float green;
  float blue;
  float depth;
};

struct TrainBlendConstants {
  uint width_px;
  uint height_px;
  float min_alpha;
  float min_transmittance;
  float log2_of_least_alpha;
  float red;  // background; of train_backward alone
  float green;
  float blue;
};

struct TrainGatherConstants {
  uint kernel_count;
};

#ifdef __cplusplus
static_assert(sizeof(TrainPixel) == 4 * kTrainHeaderWords && sizeof(TrainPixelGradient) == 20);
static_assert(sizeof(TrainEllipseGradient) == 40 && sizeof(TrainBlendConstants) == 32);
}  // namespace livegs
#endif
