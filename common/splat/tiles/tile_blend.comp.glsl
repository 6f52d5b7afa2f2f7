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

// A block of 8 x 4 pixels is one bit of a mask and 32 consecutive threads.
const int kBlockColumns = 2;
const int kBlockRows = 4;
const int kBlockWidth_px = 8;
const int kBlockHeight_px = 4;
const float kMinAlpha = 1.0 / 255.0;
const float kMaxAlpha = 0.99;
const float kMinTransmittance = 1e-4;

shared vec4 centres[kTileGroup];   // centre x, y; across x, y
shared vec2 exponents[kTileGroup];  // down y, log2 of the opacity
shared vec4 colours[kTileGroup];   // red, green, blue; the blocks that are touched, as bits
shared uint live;

float transmittance = 1.0;
vec3 sum = vec3(0.0);
bool finished = false;

uint touched_blocks(SplatRow row, vec2 corner) {
  const SplatRim rim = rim_of(row, row.log2_opacity + kSplatLog2Of255);
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

void blend(uint k, uint block_bit, vec2 pixel) {
  const vec4 colour = colours[k];
  if (finished || (floatBitsToUint(colour.w) & block_bit) == 0) return;
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
  const int block = thread / (kBlockWidth_px * kBlockHeight_px);
  const int edge = int(kTileEdge_px);
  const int columns = (int(constants.width_px) + edge - 1) / edge;
  const int tile_rows = (int(constants.height_px) + edge - 1) / edge;
  const int tile = int(gl_WorkGroupID.x);
  const ivec2 corner = edge * ivec2(tile % columns, tile / columns);
  const ivec2 pixel = corner + ivec2(block % kBlockColumns * kBlockWidth_px + thread % kBlockWidth_px,
                                     block / kBlockColumns * kBlockHeight_px +
                                         thread / kBlockWidth_px % kBlockHeight_px);
  const bool inside = pixel.x < int(constants.width_px) && pixel.y < int(constants.height_px);
  const vec2 centre = vec2(pixel) + 0.5;
  const uint block_bit = 1u << block;
  const uint list = constants.eye * uint(columns * tile_rows) + uint(tile);
  const uint end = firsts[list + 1];

  finished = !inside;
  for (uint first = firsts[list]; first < end; first += kTileGroup) {
    if (thread == 0) live = 0;
    barrier();
    if (!finished) live = 1;
    const uint i = first + uint(thread);
    colours[thread].w = 1.0;  // touches no block
    if (i < end) {
      const SplatRow row = row_of(places[i]);
      centres[thread] = vec4(row.centre_x_px, row.centre_y_px, row.across_x, row.across_y);
      exponents[thread] = vec2(row.down_y, row.log2_opacity);
      colours[thread] =
          vec4(row.red, row.green, row.blue, uintBitsToFloat(touched_blocks(row, vec2(corner)) | 0x3f800000u));
    }
    barrier();
    if (live == 0) break;
    const uint count = min(kTileGroup, end - first);
    // Four at a time, since lavapipe ends all loops of a thread after 65 535 rounds.
    for (uint k = 0; k < count && !finished; k += 4) {
      blend(k, block_bit, centre);
      blend(k + 1, block_bit, centre);
      blend(k + 2, block_bit, centre);
      blend(k + 3, block_bit, centre);
    }
    barrier();  // the next kernels replace these
  }
  if (!inside) return;
  const uint place =
      (constants.eye * constants.height_px + uint(pixel.y)) * constants.width_px + uint(pixel.x);
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
