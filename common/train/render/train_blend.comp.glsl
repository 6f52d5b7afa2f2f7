// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "splat/passes/project_splats_layout.h"
#include "train/render/train_blend_layout.h"

layout(local_size_x_id = 0) in;
layout(std430, set = 0, binding = 0) readonly restrict buffer Rows { SplatRow rows[]; };
layout(std430, set = 0, binding = 1) readonly restrict buffer Depths { float depths[]; };
layout(std430, set = 0, binding = 2) readonly restrict buffer Ranks { uint ranks[]; };
layout(std430, set = 0, binding = 3) readonly restrict buffer Pairs { uint pairs[]; };
layout(std430, set = 0, binding = 4) readonly restrict buffer Firsts { uint firsts[]; };
layout(std430, set = 0, binding = 5) writeonly restrict buffer Picture { TrainPixel picture[]; };
layout(push_constant) uniform Constants { TrainBlendConstants constants; };

#include "train/render/train_tile.glsl"

const float kHalf = 0.5;

// One group per tile, one thread per pixel, nearest kernel first: blend_forward of blend_tile.cpp. The
// header is the first row of the picture.
void main() {
  const int thread = int(gl_LocalInvocationID.x);
  const int tile = int(gl_WorkGroupID.x);
  const TilePixel pixel = tile_pixel(tile, thread, constants.width_px, constants.height_px);
  const vec2 centre = vec2(pixel.at) + 0.5;
  const uint end = firsts[tile + 1];
  TrainPixel p = TrainPixel(kTrainNone, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0u);
  bool finished = !pixel.inside;
  for (uint first = firsts[tile]; first < end; first += kTrainGroup) {
    if (thread == 0) live = 0;
    barrier();
    if (!finished) live = 1;
    const uint i = first + uint(thread);
    if (i < end) load_kernel(uint(thread), ranks[pairs[i]], pixel.corner);
    barrier();
    if (live == 0) break;
    const uint count = min(kTrainGroup, end - first);
    for (uint k = 0; k < count && !finished; ++k) {
      if ((blocks_at(k) & pixel.block) == 0) continue;
      const Step s = step_of(k, centre);
      if (s.alpha < constants.min_alpha) continue;
      const float weight = s.alpha * p.through;
      const float after = p.through - weight;
      if (after < constants.min_transmittance) {
        finished = true;
        continue;
      }
      const vec3 colour = colours[k];
      p.red += weight * colour.r;
      p.green += weight * colour.g;
      p.blue += weight * colour.b;
      const float depth = exponents[k].z;
      p.spread += 2.0 * weight * (depth * (1.0 - p.through) - p.depth_sum);
      p.depth_sum += weight * depth;
      if (p.through >= kHalf && after < kHalf) p.halfway = ranks_here[k];
      p.through = after;
    }
    barrier();  // the next kernels replace these
  }
  if (pixel.inside) picture[1 + uint(pixel.at.y) * constants.width_px + uint(pixel.at.x)] = p;
}
