// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_multiview : require
#include "render/vulkan/draw_splats_layout.h"
#include "splat/passes/project_splats_layout.h"

layout(std430, set = 0, binding = 0) readonly restrict buffer Order { uint order[]; };
layout(std430, set = 0, binding = 1) readonly restrict buffer Left0 { SplatRow left_rows_0[]; };
layout(std430, set = 0, binding = 2) readonly restrict buffer Left1 { SplatRow left_rows_1[]; };
layout(std430, set = 0, binding = 3) readonly restrict buffer Left2 { SplatRow left_rows_2[]; };
layout(std430, set = 0, binding = 4) readonly restrict buffer Right0 { SplatRow right_rows_0[]; };
layout(std430, set = 0, binding = 5) readonly restrict buffer Right1 { SplatRow right_rows_1[]; };
layout(std430, set = 0, binding = 6) readonly restrict buffer Right2 { SplatRow right_rows_2[]; };
layout(push_constant) uniform Constants { DrawSplatsConstants constants; };

layout(location = 0) flat out vec4 centre_across;
layout(location = 1) flat out vec4 colour_log2_opacity;
layout(location = 2) flat out float down_y;

// One splat per instance, nearest first: the parallelogram around the ellipse at whose rim alpha is 1/255. It
// is the square around a circle, transformed by the inverse of the root form. Its area equals that of the
// rectangle along the ellipse's axes, without the need for eigenvectors.
void main() {
  const uint place = order[gl_InstanceIndex];
  const bool left = constants.first_eye + gl_ViewIndex == 0;
  SplatRow row;
  if (place < constants.part_rows) {  // nearly always; scenes of millions of kernels need more parts
    if (left) row = left_rows_0[place];
    else row = right_rows_0[place];
  } else if (place < 2 * constants.part_rows) {
    const uint within = place - constants.part_rows;
    if (left) row = left_rows_1[within];
    else row = right_rows_1[within];
  } else {
    const uint within = place - 2 * constants.part_rows;
    if (left) row = left_rows_2[within];
    else row = right_rows_2[within];
  }
  centre_across = vec4(row.centre_x_px, row.centre_y_px, row.across_x, row.across_y);
  colour_log2_opacity = vec4(row.red, row.green, row.blue, row.log2_opacity);
  down_y = row.down_y;
  const float rim = row.log2_opacity + kSplatLog2Of255;
  if (!(rim > 0.0)) {  // not visible to this eye
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    return;
  }
  const float reach = sqrt(rim) + 1e-3;  // margin for rounding; the fragment shader decides by alpha
  const float u = (gl_VertexIndex & 1) == 0 ? -reach : reach;
  const float v = (gl_VertexIndex & 2) == 0 ? -reach : reach;
  const float dy = v / row.down_y;
  const float dx = (u - row.across_y * dy) / row.across_x;
  const vec2 pixel = vec2(row.centre_x_px + dx, row.centre_y_px + dy);
  gl_Position = vec4(2.0 * pixel / vec2(constants.width_px, constants.height_px) - 1.0, 0.0, 1.0);
}
