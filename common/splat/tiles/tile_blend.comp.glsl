// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "splat/passes/project_splats_layout.h"
#include "splat/tiles/tile_splats_layout.h"

layout(local_size_x_id = 0) in;
layout(std430, set = 0, binding = 0) readonly restrict buffer Rows0 { SplatRow rows_0[]; };
layout(std430, set = 0, binding = 1) readonly restrict buffer Rows1 { SplatRow rows_1[]; };
layout(std430, set = 0, binding = 2) readonly restrict buffer Rows2 { SplatRow rows_2[]; };
layout(std430, set = 0, binding = 3) readonly restrict buffer Places { uint places[]; };
layout(std430, set = 0, binding = 4) readonly restrict buffer Firsts { uint firsts[]; };
layout(std430, set = 0, binding = 5) writeonly restrict buffer Picture { uint picture[]; };
layout(push_constant) uniform Constants { TileBlendConstants constants; };

#include "splat/tiles/splat_rim.glsl"
#include "splat/tiles/splat_rows.glsl"
#include "splat/tiles/tile_blocks.glsl"

const float kMinAlpha = 1.0 / 255.0;
const float kMinTransmittance = 1e-4;

shared vec4 centres[kTileGroup];   // centre x, y; across x, y
shared vec2 exponents[kTileGroup];  // down y, log2 of the opacity
shared vec4 colours[kTileGroup];   // red, green, blue; the blocks that are touched, as bits
shared uint live;

float transmittance = 1.0;
vec3 sum = vec3(0.0);
bool finished = false;

void blend(uint k, uint block_bit, vec2 pixel) {
  const vec4 colour = colours[k];
  if (finished || (blocks_of_float(colour.w) & block_bit) == 0) return;
  const vec4 placed = centres[k];
  const vec2 exponent = exponents[k];
  const vec2 d = pixel - placed.xy;
  const float u = placed.z * d.x + placed.w * d.y;
  const float v = exponent.x * d.y;
  const float alpha = min(kMaxAlpha, exp2(exponent.y - v * v - u * u));
  if (alpha < kMinAlpha) return;
  const float weight = alpha * transmittance;
  const float after = transmittance - weight;
  if (after < kMinTransmittance) {
    finished = true;
  } else {
    sum += weight * colour.rgb;
    transmittance = after;
  }
}

// One group per tile, one thread per pixel, nearest kernel first. A pixel whose transmittance would fall
// below kMinTransmittance is finished and keeps its last value, as in raster/blend_tiles.cpp.
void main() {
  const int thread = int(gl_LocalInvocationID.x);
  const ivec2 tiles = tiles_of(constants.width_px, constants.height_px);
  const TilePixel pixel =
      tile_pixel(int(gl_WorkGroupID.x), thread, constants.width_px, constants.height_px);
  const vec2 centre = vec2(pixel.at) + 0.5;
  const uint list = constants.eye * uint(tiles.x * tiles.y) + gl_WorkGroupID.x;
  const uint end = firsts[list + 1];

  finished = !pixel.inside;
  for (uint first = firsts[list]; first < end; first += kTileGroup) {
    if (thread == 0) live = 0;
    barrier();
    if (!finished) live = 1;
    const uint i = first + uint(thread);
    colours[thread].w = float_of_blocks(0u);
    if (i < end) {
      const SplatRow row = row_of(places[i]);
      centres[thread] = vec4(row.centre_x_px, row.centre_y_px, row.across_x, row.across_y);
      exponents[thread] = vec2(row.down_y, row.log2_opacity);
      const uint blocks =
          touched_blocks(row, row.log2_opacity + kSplatLog2Of255, pixel.corner, constants.width_px);
      colours[thread] = vec4(row.red, row.green, row.blue, float_of_blocks(blocks));
    }
    barrier();
    if (live == 0) break;
    const uint count = min(kTileGroup, end - first);
    // Four at a time, since lavapipe ends all loops of a thread after 65 535 rounds.
    for (uint k = 0; k < count && !finished; k += 4) {
      blend(k, pixel.block, centre);
      blend(k + 1, pixel.block, centre);
      blend(k + 2, pixel.block, centre);
      blend(k + 3, pixel.block, centre);
    }
    barrier();  // the next kernels replace these
  }
  if (!pixel.inside) return;
  const uint place =
      (constants.eye * constants.height_px + uint(pixel.at.y)) * constants.width_px + uint(pixel.at.x);
  const float coverage = 1.0 - transmittance;
  if (constants.floats != 0) {
    const uint word = kTileHeaderWords + 4 * place;
    picture[word] = floatBitsToUint(sum.r);
    picture[word + 1] = floatBitsToUint(sum.g);
    picture[word + 2] = floatBitsToUint(sum.b);
    picture[word + 3] = floatBitsToUint(coverage);
  } else {
    const vec3 shown = sum + transmittance * vec3(constants.red, constants.green, constants.blue);
    picture[kTileHeaderWords + place] = packUnorm4x8(vec4(shown, coverage));
  }
}
