// SPDX-License-Identifier: GPL-3.0-or-later
#version 460
#extension GL_GOOGLE_include_directive : require
#include "device/passes/elastic_layout.h"

layout(local_size_x_id = 0) in;
layout(std430, set = 0, binding = 0) buffer Bodies { BodyRow bodies[]; };
layout(std430, set = 0, binding = 1) readonly buffer Cells { CellRow cells[]; };
layout(std430, set = 0, binding = 2) buffer Rotations { vec4 rotations[]; };
layout(std430, set = 0, binding = 3) buffer Solve { NodeSolveRow solve[]; };
layout(std430, set = 0, binding = 4) readonly buffer Rows { float rows[]; };
layout(std430, set = 0, binding = 5) readonly buffer Gains { float gains[]; };
layout(push_constant) uniform Constants { ElasticConstants constants; };

#include "device/passes/elastic_cells_body.h"

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i < constants.count)
    solve_cell(i < constants.split ? constants.first + i : constants.second + (i - constants.split),
               constants.step, constants.rank, constants.rank_count, constants.row_count);
}
