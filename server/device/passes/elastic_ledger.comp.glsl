// SPDX-License-Identifier: GPL-3.0-or-later
#version 460
#extension GL_GOOGLE_include_directive : require
#include "device/passes/elastic_sums.h"

layout(local_size_x_id = 0) in;
layout(std430, set = 0, binding = 0) buffer Bodies { BodyRow bodies[]; };
layout(std430, set = 0, binding = 1) readonly buffer Blocks { NodeSumsRow blocks[]; };
layout(std430, set = 0, binding = 2) readonly buffer Contacts { ContactSumsRow contacts[]; };
layout(push_constant) uniform Constants { ElasticConstants constants; };

#include "device/passes/elastic_ledger_body.h"

shared NodeSumsRow node_parts[kElasticBlock];
shared ContactSumsRow contact_parts[kElasticBlock];

// A group is a body.
void main() {
  const uint thread = gl_LocalInvocationID.x, body = gl_WorkGroupID.x;
  const uint steps = bodies[body].steps;
  if (constants.step >= steps) return;
  if (constants.begins != 0) {
    if (thread == 0) begin_step(body);
    return;
  }
  NodeSumsRow nodes = no_node_sums();
  const uint block_end = bodies[body].first_block + bodies[body].block_count;
  for (uint k = bodies[body].first_block + thread; k < block_end; k += kElasticBlock) nodes = sum_of(nodes, blocks[k]);
  node_parts[thread] = nodes;
  ContactSumsRow touching = no_contact_sums();
  if (bodies[body].collider_count > 0) {
    const uint cell_end = bodies[body].first_surface + bodies[body].surface_count;
    for (uint k = bodies[body].first_surface + thread; k < cell_end; k += kElasticBlock)
      touching = sum_of(touching, contacts[k]);
  }
  contact_parts[thread] = touching;
  for (uint stride = kElasticBlock / 2; stride > 0; stride /= 2) {
    barrier();
    if (thread < stride) {
      node_parts[thread] = sum_of(node_parts[thread], node_parts[thread + stride]);
      contact_parts[thread] = sum_of(contact_parts[thread], contact_parts[thread + stride]);
    }
  }
  if (thread == 0) {
    finish_step(body, node_parts[0], contact_parts[0]);
    if (constants.step + 1 < steps) begin_step(body);
  }
}
