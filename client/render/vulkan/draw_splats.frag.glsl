// SPDX-License-Identifier: Apache-2.0
#version 460

layout(location = 0) flat in vec4 centre_across;
layout(location = 1) flat in vec4 colour_log2_opacity;
layout(location = 2) flat in float down_y;

layout(location = 0) out vec4 premultiplied;

// Evaluates a ProjectedKernel. Uses the pixel's own coordinates: interpolated ones would be wrong by pixels
// for splats much larger than the screen.
void main() {
  const vec2 d = gl_FragCoord.xy - centre_across.xy;
  const float u = centre_across.z * d.x + centre_across.w * d.y;
  const float v = down_y * d.y;
  const float alpha = min(0.99, exp2(colour_log2_opacity.w - v * v - u * u));
  if (alpha < 1.0 / 255.0) discard;
  premultiplied = vec4(alpha * colour_log2_opacity.rgb, alpha);
}
