// SPDX-License-Identifier: Apache-2.0

// What the draw and the resolve are told, for C++ and GLSL alike.

#ifdef __cplusplus
#pragma once
#include <cstdint>
namespace livegs {
using uint = uint32_t;
#endif

struct DrawSplatsConstants {
  float width_px;
  float height_px;
  uint first_eye;  // that view 0 is of
  uint part_rows;  // in each buffer of rows but the last
};

// Behind the splats, in the colour space they were trained in.
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
