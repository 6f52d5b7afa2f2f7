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
layout(std430, set = 0, binding = 5) readonly restrict buffer Picture { TrainPixel picture[]; };
layout(std430, set = 0, binding = 6) readonly restrict buffer ByPicture { TrainPixelGradient by_picture[]; };
layout(std430, set = 0, binding = 7) writeonly restrict buffer Gradients { float gradients[]; };
layout(push_constant) uniform Constants { TrainBlendConstants constants; };

#include "train/render/train_tile.glsl"

const uint kNumbers = 10;  // of a TrainEllipseGradient
const uint kParts = 16;    // partial sums of a number

shared float terms[kNumbers * kTrainGroup];
shared float partial_sums[kNumbers * kParts];

void clear_gradient(uint i) {
  for (uint n = 0; n < kNumbers; ++n) gradients[kNumbers * pairs[i] + n] = 0.0;
}

// One group per tile, one thread per pixel, nearest kernel first: blend_backward of blend_tile.cpp. The
// terms of all pixels of a pair are added in a fixed order, sixteen at a time, so that the sum has the same
// bits in every run.
void main() {
  const uint thread = gl_LocalInvocationID.x;
  const int tile = int(gl_WorkGroupID.x);
  const TilePixel pixel = tile_pixel(tile, int(thread), constants.width_px, constants.height_px);
  const vec2 centre = vec2(pixel.at) + 0.5;
  const ivec2 tiles = tiles_of(constants.width_px, constants.height_px);
  if (tile == tiles.x * tiles.y) {  // pairs of no tile (tile_pairs)
    const uint pair_count = picture[0].halfway;  // the header
    for (uint i = firsts[tile] + thread; i < pair_count; i += kTrainGroup) clear_gradient(i);
    return;
  }
  const uint end = firsts[tile + 1];

  vec4 by = vec4(0.0);  // dL by red, green, blue, alpha
  float left = 0.0;     // of the loss behind the current kernel
  float by_spread = 0.0;
  float final_alpha = 0.0;
  float final_depth = 0.0;
  if (pixel.inside) {
    const uint place = uint(pixel.at.y) * constants.width_px + uint(pixel.at.x);
    const TrainPixelGradient g = by_picture[place];
    const TrainPixel p = picture[1 + place];
    by = vec4(g.red, g.green, g.blue, g.alpha);
    by_spread = g.spread;
    final_alpha = 1.0 - p.through;
    final_depth = p.depth_sum;
    const vec3 shown =
        vec3(p.red, p.green, p.blue) + p.through * vec3(constants.red, constants.green, constants.blue);
    left = dot(by.rgb, shown) + by.a * final_alpha + 2.0 * by_spread * p.spread;
  }
  float through = 1.0;
  float depth_sum = 0.0;
  bool finished = !pixel.inside;
  for (uint first = firsts[tile]; first < end; first += kTrainGroup) {
    if (thread == 0) live = 0;
    barrier();
    if (!finished) live = 1;
    const uint i = first + thread;
    if (i < end) load_kernel(thread, ranks[pairs[i]], pixel.corner);
    barrier();
    if (live == 0) {  // nothing behind is seen
      for (uint j = first + thread; j < end; j += kTrainGroup) clear_gradient(j);
      break;
    }
    const uint count = min(kTrainGroup, end - first);
    for (uint k = 0; k < count; ++k) {
      const uint gradient = kNumbers * pairs[first + k];
      if (blocks_at(k) == 0) {
        if (thread < kNumbers) gradients[gradient + thread] = 0.0;
        continue;
      }
      float term[kNumbers] = float[](0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
      if (!finished && (blocks_at(k) & pixel.block) != 0) {
        const Step s = step_of(k, centre);
        const float weight = s.alpha * through;
        const float after = through - weight;
        if (s.alpha >= constants.min_alpha) {
          if (after < constants.min_transmittance) {
            finished = true;
          } else {
            const vec3 colour = colours[k];
            const float depth = exponents[k].z;
            float by_weight = dot(by.rgb, colour) + by.a;
            if (by_spread != 0.0) {
              const float balance = 2.0 * (1.0 - through) - final_alpha;
              by_weight += 2.0 * by_spread * (depth * balance - (2.0 * depth_sum - final_depth));
              term[9] = by_spread * 2.0 * weight * (balance + weight);
              depth_sum += weight * depth;
            }
            left -= weight * by_weight;
            const float g =
                s.free_alpha > kMaxAlpha ? 0.0 : weight * by_weight - s.alpha * left / (1.0 - s.alpha);
            term[0] = g;
            term[1] = g * s.d.x;
            term[2] = g * s.d.y;
            term[3] = g * s.d.x * s.d.x;
            term[4] = g * s.d.x * s.d.y;
            term[5] = g * s.d.y * s.d.y;
            term[6] = weight * by.r;
            term[7] = weight * by.g;
            term[8] = weight * by.b;
            through = after;
          }
        }
      }
      for (uint n = 0; n < kNumbers; ++n) terms[n * kTrainGroup + thread] = term[n];
      barrier();
      if (thread < kNumbers * kParts) {
        const uint begin = thread / kParts * kTrainGroup + thread % kParts;
        float sum = 0.0;
        for (uint t = 0; t < kTrainGroup; t += kParts) sum += terms[begin + t];
        partial_sums[thread] = sum;
      }
      barrier();
      if (thread < kNumbers) {
        float sum = 0.0;
        for (uint part = 0; part < kParts; ++part) sum += partial_sums[thread * kParts + part];
        gradients[gradient + thread] = sum;
      }
    }
    barrier();  // the next kernels replace these
  }
}
