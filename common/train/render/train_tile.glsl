// SPDX-License-Identifier: Apache-2.0
// Shared by train_blend and train_backward: the kernels of a tile in shared memory, and a step of blending.

#include "splat/tiles/splat_rim.glsl"
#include "splat/tiles/tile_blocks.glsl"

shared vec4 centres[kTrainGroup];    // centre x, y; across x, y
shared vec4 exponents[kTrainGroup];  // down y, log2 of the opacity, depth, touched blocks as bits
shared vec3 colours[kTrainGroup];
shared uint ranks_here[kTrainGroup];
shared uint live;

// Loads the kernel of a pair of the list into the place of this thread.
void load_kernel(uint thread, uint rank, vec2 corner) {
  const SplatRow row = rows[rank];
  centres[thread] = vec4(row.centre_x_px, row.centre_y_px, row.across_x, row.across_y);
  const uint blocks =
      touched_blocks(row, row.log2_opacity - constants.log2_of_least_alpha, corner, constants.width_px);
  exponents[thread] = vec4(row.down_y, row.log2_opacity, depths[rank], float_of_blocks(blocks));
  colours[thread] = vec3(row.red, row.green, row.blue);
  ranks_here[thread] = rank;
}

uint blocks_at(uint k) { return blocks_of_float(exponents[k].w); }

struct Step {
  float free_alpha;  // before the limit
  float alpha;
  vec2 d;  // from the centre, px
};

Step step_of(uint k, vec2 pixel) {
  const vec4 placed = centres[k];
  const vec4 exponent = exponents[k];
  const vec2 d = pixel - placed.xy;
  const float u = placed.z * d.x + placed.w * d.y;
  const float v = exponent.x * d.y;
  const float free_alpha = exp2(exponent.y - v * v - u * u);
  return Step(free_alpha, min(kMaxAlpha, free_alpha), d);
}
