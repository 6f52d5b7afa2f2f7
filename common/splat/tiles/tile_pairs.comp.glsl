// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "splat/passes/project_splats_layout.h"
#include "splat/passes/sort_keys_layout.h"
#include "splat/tiles/tile_splats_layout.h"

layout(local_size_x_id = 0) in;
layout(std430, set = 0, binding = 0) readonly restrict buffer Rows0 { SplatRow rows_0[]; };
layout(std430, set = 0, binding = 1) readonly restrict buffer Rows1 { SplatRow rows_1[]; };
layout(std430, set = 0, binding = 2) readonly restrict buffer Rows2 { SplatRow rows_2[]; };
layout(std430, set = 0, binding = 3) readonly restrict buffer Order { uint order[]; };
layout(std430, set = 0, binding = 4) readonly restrict buffer Drawn { SortedCount drawn; };
layout(std430, set = 0, binding = 5) restrict buffer Sums { uint sums[]; };
layout(std430, set = 0, binding = 6) writeonly restrict buffer Tiles { uint tiles[]; };
layout(std430, set = 0, binding = 7) writeonly restrict buffer Places { uint places[]; };
layout(push_constant) uniform Constants { TilePairsConstants constants; };

#include "splat/tiles/splat_rim.glsl"
#include "splat/tiles/splat_rows.glsl"

shared uint scanned[kTileGroup];

// One kernel per thread, in draw order. Runs twice: first each block writes the number of its pairs; then,
// with the sums of the blocks before it, the pairs. Both runs count with the same instructions.
void main() {
  const uint thread = gl_LocalInvocationID.x;
  const uint i = gl_GlobalInvocationID.x;
  const float width = float(constants.width_px);
  const float height = float(constants.height_px);
  const int edge = int(kTileEdge_px);
  const int columns = (int(constants.width_px) + edge - 1) / edge;
  const int tile_rows = (int(constants.height_px) + edge - 1) / edge;
  const uint first_tile = constants.eye * uint(columns * tile_rows);

  SplatRim rim = SplatRim(0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0);
  ivec2 rows = ivec2(1, 0);
  uint place = 0;
  if (i < drawn.instance_count) {
    place = order[i];
    const SplatRow row = row_of(place);
    const float rim_value = row.log2_opacity - constants.log2_of_least_alpha;
    if (rim_value > 0.0) {  // visible to this eye
      rim = rim_of(row, rim_value);
      rows = rows_of(rim, height);
    }
  }
  const int first_row = rows.x / edge;
  const int last_row = rows.x <= rows.y ? rows.y / edge : first_row - 1;
  uint count = 0;
  for (int r = first_row; r <= last_row; ++r) {
    const ivec2 span = columns_of(rim, float(r * edge), min(float(r * edge + edge), height), width);
    if (span.x <= span.y) count += uint(span.y / edge - span.x / edge + 1);
  }
  scanned[thread] = count;
  barrier();
  for (uint reach = 1; reach < kTileGroup; reach *= 2) {
    const uint before = thread >= reach ? scanned[thread - reach] : 0;
    barrier();
    scanned[thread] += before;
    barrier();
  }
  const uint block = constants.eye * constants.block_capacity + gl_WorkGroupID.x;
  if (constants.pair_capacity == 0) {
    if (thread == kTileGroup - 1) sums[block] = scanned[thread];
    return;
  }
  const uint block_begin = sums[block];
  if (count == 0 || block_begin >= constants.pair_capacity) return;
  uint next = block_begin + scanned[thread] - count;
  const uint end = min(next + count, constants.pair_capacity);
  for (int r = first_row; r <= last_row; ++r) {
    const ivec2 span = columns_of(rim, float(r * edge), min(float(r * edge + edge), height), width);
    if (span.x > span.y) continue;
    for (int c = span.x / edge; c <= span.y / edge && next < end; ++c) {
      tiles[next] = first_tile + uint(r * columns + c);
      places[next] = place;
      ++next;
    }
  }
  for (; next < end; ++next) {
    tiles[next] = constants.no_tile;
    places[next] = place;
  }
}
