// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_multiview : require
#include "render/draw_splats_layout.h"
#include "splat/project_splats_layout.h"

layout(std430, set = 0, binding = 0) readonly restrict buffer Left { SplatRow left_rows[]; };
layout(std430, set = 0, binding = 1) readonly restrict buffer Right { SplatRow right_rows[]; };
layout(std430, set = 0, binding = 2) readonly restrict buffer Order { uint order[]; };
layout(push_constant) uniform Constants { DrawSplatsConstants constants; };

layout(location = 0) flat out vec4 centre_across;
layout(location = 1) flat out vec4 colour_log2_opacity;
layout(location = 2) flat out float down_y;

// One splat an instance, nearest first: the parallelogram about the ellipse at whose rim alpha is 1/255. It is the square
// about a circle, taken through the inverse of the root form, and has the area of the rectangle along the ellipse's axes,
// of which no eigenvectors are needed.
void main() {
  const uint place = order[gl_InstanceIndex];
  SplatRow row;
  if (constants.first_eye + gl_ViewIndex == 0) {
    row = left_rows[place];
  } else {
    row = right_rows[place];
  }
  centre_across = vec4(row.centre_x_px, row.centre_y_px, row.across_x, row.across_y);
  colour_log2_opacity = vec4(row.red, row.green, row.blue, row.log2_opacity);
  down_y = row.down_y;
  const float rim = row.log2_opacity + kSplatLog2Of255;
  if (!(rim > 0.0)) {  // this eye sees nothing of it
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    return;
  }
  const float reach = sqrt(rim) + 1e-3;  // rounding cuts off no pixel; alpha decides
  const float u = (gl_VertexIndex & 1) == 0 ? -reach : reach;
  const float v = (gl_VertexIndex & 2) == 0 ? -reach : reach;
  const float dy = v / row.down_y;
  const float dx = (u - row.across_y * dy) / row.across_x;
  const vec2 pixel = vec2(row.centre_x_px + dx, row.centre_y_px + dy);
  gl_Position = vec4(2.0 * pixel / vec2(constants.width_px, constants.height_px) - 1.0, 0.0, 1.0);
}
