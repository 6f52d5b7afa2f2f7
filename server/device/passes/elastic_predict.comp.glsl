// SPDX-License-Identifier: GPL-3.0-or-later
#version 460
#extension GL_GOOGLE_include_directive : require
#include "device/passes/elastic_layout.h"

layout(local_size_x_id = 0) in;
layout(std430, set = 0, binding = 0) readonly buffer Bodies { BodyRow bodies[]; };
layout(std430, set = 0, binding = 1) buffer Now { NodeStateRow now[]; };
layout(std430, set = 0, binding = 2) readonly buffer Before { NodeStateRow before[]; };
layout(std430, set = 0, binding = 3) writeonly buffer Solve { NodeSolveRow solve[]; };
layout(std430, set = 0, binding = 4) writeonly buffer Drift { NodeDriftRow drift[]; };
layout(std430, set = 0, binding = 5) readonly buffer Loads { vec4 loads[]; };
layout(std430, set = 0, binding = 6) readonly buffer BlockBodies { uint block_bodies[]; };
layout(push_constant) uniform Constants { ElasticConstants constants; };

#include "device/passes/elastic_nodes_body.h"

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= constants.count) return;
  const uint body = block_bodies[i / kElasticBlock];
  if (constants.step < bodies[body].steps) predict_node(body, i);
}
