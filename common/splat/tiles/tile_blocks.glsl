// SPDX-License-Identifier: Apache-2.0
// For groups with one thread per pixel of a tile. A block of 8 x 4 pixels is one bit of a mask and 32
// consecutive threads. Needs splat_rim.glsl.

const float kMaxAlpha = 0.99;
const int kTileEdge = 16;  // px, kTileEdge_px
const int kBlockColumns = 2;
const int kBlockRows = 4;
const int kBlockWidth_px = 8;
const int kBlockHeight_px = 4;

ivec2 tiles_of(uint width_px, uint height_px) {
  return (ivec2(width_px, height_px) + kTileEdge - 1) / kTileEdge;
}

struct TilePixel {
  vec2 corner;  // first pixel of the tile
  ivec2 at;     // pixel of this thread
  bool inside;  // the picture
  uint block;   // its bit
};

TilePixel tile_pixel(int tile, int thread, uint width_px, uint height_px) {
  const int block = thread / (kBlockWidth_px * kBlockHeight_px);
  const int columns = tiles_of(width_px, height_px).x;
  const ivec2 corner = kTileEdge * ivec2(tile % columns, tile / columns);
  const ivec2 at = corner + ivec2(block % kBlockColumns * kBlockWidth_px + thread % kBlockWidth_px,
                                  block / kBlockColumns * kBlockHeight_px +
                                      thread / kBlockWidth_px % kBlockHeight_px);
  return TilePixel(vec2(corner), at, at.x < int(width_px) && at.y < int(height_px), 1u << block);
}

// The blocks that an ellipse touches. `rim`: as in rim_of.
uint touched_blocks(SplatRow row, float rim_value, vec2 corner, uint width_px) {
  const SplatRim rim = rim_of(row, rim_value);
  uint blocks = 0;
  for (int r = 0; r < kBlockRows; ++r) {
    const float top = corner.y + float(r * kBlockHeight_px);
    const ivec2 span = columns_of(rim, top, top + float(kBlockHeight_px), float(width_px));
    if (span.x > span.y) continue;
    const int middle = int(corner.x) + kBlockWidth_px;
    if (span.x < middle) blocks |= 1u << (kBlockColumns * r);
    if (span.y >= middle) blocks |= 2u << (kBlockColumns * r);
  }
  return blocks;
}

// A mask as a normal float, and back.
float float_of_blocks(uint blocks) { return uintBitsToFloat(blocks | 0x3f800000u); }
uint blocks_of_float(float value) { return floatBitsToUint(value) & 0xffu; }
