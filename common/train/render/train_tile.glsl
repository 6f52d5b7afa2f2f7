// SPDX-License-Identifier: Apache-2.0
// Shared by train_blend and train_backward: the kernels of a tile in shared memory, and a step of blending.

const float kMaxAlpha = 0.99;
const int kBlockColumns = 2;  // a block of 8 x 4 pixels is one bit of a mask and 32 consecutive threads
const int kBlockRows = 4;
const int kBlockWidth_px = 8;
const int kBlockHeight_px = 4;

shared vec4 centres[kTrainGroup];    // centre x, y; across x, y
shared vec4 exponents[kTrainGroup];  // down y, log2 of the opacity, depth, touched blocks as bits
shared vec3 colours[kTrainGroup];
shared uint ranks_here[kTrainGroup];
shared uint live;

uint touched_blocks(SplatRow row, vec2 corner) {
  const SplatRim rim = rim_of(row, row.log2_opacity - constants.log2_of_least_alpha);
  uint blocks = 0;
  for (int r = 0; r < kBlockRows; ++r) {
    const float top = corner.y + float(r * kBlockHeight_px);
    const ivec2 span = columns_of(rim, top, top + float(kBlockHeight_px), float(constants.width_px));
    if (span.x > span.y) continue;
    const int middle = int(corner.x) + kBlockWidth_px;
    if (span.x < middle) blocks |= 1u << (kBlockColumns * r);
    if (span.y >= middle) blocks |= 2u << (kBlockColumns * r);
  }
  return blocks;
}

// Loads the kernel of a pair of the list into the place of this thread.
void load_kernel(uint thread, uint rank, vec2 corner) {
  const SplatRow row = rows[rank];
  centres[thread] = vec4(row.centre_x_px, row.centre_y_px, row.across_x, row.across_y);
  exponents[thread] =
      vec4(row.down_y, row.log2_opacity, depths[rank], uintBitsToFloat(touched_blocks(row, corner) | 0x3f800000u));
  colours[thread] = vec3(row.red, row.green, row.blue);
  ranks_here[thread] = rank;
}

uint blocks_at(uint k) { return floatBitsToUint(exponents[k].w) & 0xffu; }

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
