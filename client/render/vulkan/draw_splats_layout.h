// SPDX-License-Identifier: Apache-2.0

// Push constants of the draw and resolve passes, shared by C++ and GLSL.

#ifdef __cplusplus
#pragma once
#include <cstdint>
namespace livegs {
using uint = uint32_t;
#endif

struct DrawSplatsConstants {
  float width_px;
  float height_px;
  uint first_eye;  // eye of view 0
  uint part_rows;  // in each buffer of rows except the last
};

// Background, in the colour space of training.
struct ResolveConstants {
  float red;
  float green;
  float blue;
  uint first_eye;
};

#ifdef __cplusplus
static_assert(sizeof(DrawSplatsConstants) == 16 && sizeof(ResolveConstants) == 16);
}  // namespace livegs
#endif
