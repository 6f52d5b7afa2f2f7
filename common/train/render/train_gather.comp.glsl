// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "train/render/train_blend_layout.h"

layout(local_size_x_id = 0) in;
layout(std430, set = 0, binding = 0) readonly restrict buffer Firsts { uint firsts[]; };
layout(std430, set = 0, binding = 1) readonly restrict buffer Pairs { TrainEllipseGradient pairs[]; };
layout(std430, set = 0, binding = 2) writeonly restrict buffer Kernels { TrainEllipseGradient kernels[]; };
layout(push_constant) uniform Constants { TrainGatherConstants constants; };

// Adds the gradients of the pairs of each kernel in their order.
void main() {
  const uint rank = gl_GlobalInvocationID.x;
  if (rank >= constants.kernel_count) return;
  TrainEllipseGradient total = TrainEllipseGradient(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
  for (uint i = firsts[rank]; i < firsts[rank + 1]; ++i) {
    const TrainEllipseGradient one = pairs[i];
    total.sum += one.sum;
    total.x += one.x;
    total.y += one.y;
    total.xx += one.xx;
    total.xy += one.xy;
    total.yy += one.yy;
    total.red += one.red;
    total.green += one.green;
    total.blue += one.blue;
    total.depth += one.depth;
  }
  kernels[rank] = total;
}
