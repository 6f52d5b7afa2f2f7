// SPDX-License-Identifier: GPL-3.0-or-later
#version 460
#extension GL_GOOGLE_include_directive : require
#include "device/passes/elastic_sums.h"

layout(local_size_x_id = 0) in;
layout(std430, set = 0, binding = 0) readonly buffer Bodies { BodyRow bodies[]; };
layout(std430, set = 0, binding = 1) buffer Now { NodeStateRow now[]; };
layout(std430, set = 0, binding = 2) writeonly buffer Before { NodeStateRow before[]; };
layout(std430, set = 0, binding = 3) readonly buffer Solve { NodeSolveRow solve[]; };
layout(std430, set = 0, binding = 4) readonly buffer Drift { NodeDriftRow drift[]; };
layout(std430, set = 0, binding = 5) readonly buffer Loads { vec4 loads[]; };
layout(std430, set = 0, binding = 6) writeonly buffer Blocks { NodeSumsRow blocks[]; };
layout(std430, set = 0, binding = 7) readonly buffer BlockBodies { uint block_bodies[]; };
layout(push_constant) uniform Constants { ElasticConstants constants; };

#include "device/passes/elastic_advance_body.h"

shared NodeSumsRow parts[kElasticBlock];

// A group is a block, of one body; `count` is a multiple of the block.
void main() {
  const uint thread = gl_LocalInvocationID.x, block = gl_WorkGroupID.x;
  const uint body = block_bodies[block];
  if (constants.step >= bodies[body].steps) return;
  parts[thread] = advance_node(body, block * kElasticBlock + thread);
  for (uint stride = kElasticBlock / 2; stride > 0; stride /= 2) {
    barrier();
    if (thread < stride) parts[thread] = sum_of(parts[thread], parts[thread + stride]);
  }
  if (thread == 0) blocks[block] = parts[0];
}
