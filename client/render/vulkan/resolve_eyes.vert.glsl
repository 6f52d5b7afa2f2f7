// SPDX-License-Identifier: Apache-2.0
#version 460

// One triangle over the whole screen.
void main() {
  const vec2 corner = vec2((gl_VertexIndex & 1) * 4.0 - 1.0, (gl_VertexIndex & 2) * 2.0 - 1.0);
  gl_Position = vec4(corner, 0.0, 1.0);
}
