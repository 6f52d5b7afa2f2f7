// SPDX-License-Identifier: Apache-2.0
#version 460

layout(local_size_x_id = 0) in;
layout(std430, set = 0, binding = 0) readonly restrict buffer Words { uint words[]; };
layout(std430, set = 0, binding = 1) writeonly restrict buffer Shifted { uint shifted[]; };
layout(push_constant) uniform Constants { uint count; };

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i < count) shifted[i] = words[(i + 1) % count] + 1;
}
