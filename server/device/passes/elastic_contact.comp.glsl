// SPDX-License-Identifier: GPL-3.0-or-later
#version 460
#extension GL_GOOGLE_include_directive : require
#include "device/passes/elastic_sums.h"

layout(local_size_x_id = 0) in;
layout(std430, set = 0, binding = 0) readonly buffer Bodies { BodyRow bodies[]; };
layout(std430, set = 0, binding = 1) readonly buffer Cells { SurfaceCellRow cells[]; };
layout(std430, set = 0, binding = 2) readonly buffer Points { SurfacePointRow points[]; };
layout(std430, set = 0, binding = 3) readonly buffer Now { NodeStateRow now[]; };
layout(std430, set = 0, binding = 4) readonly buffer Solve { NodeSolveRow solve[]; };
layout(std430, set = 0, binding = 5) buffer Drift { NodeDriftRow drift[]; };
layout(std430, set = 0, binding = 6) writeonly buffer Contacts { ContactSumsRow contacts[]; };
layout(std430, set = 0, binding = 7) readonly buffer Colliders { ColliderRow colliders[]; };
layout(push_constant) uniform Constants { ElasticConstants constants; };

#include "device/passes/elastic_contact_body.h"

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i < constants.count)
    resolve_cell(i < constants.split ? constants.first + i : constants.second + (i - constants.split),
               constants.step, constants.rank, constants.rank_count);
}
