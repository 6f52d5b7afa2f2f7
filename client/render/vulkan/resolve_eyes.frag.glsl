// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_multiview : require
#extension GL_EXT_samplerless_texture_functions : require
#include "render/vulkan/draw_splats_layout.h"

layout(set = 0, binding = 0) uniform texture2DArray blended;
layout(push_constant) uniform Constants { ResolveConstants constants; };

layout(location = 0) out vec4 linear_light;

// IEC 61966-2-1.
vec3 decode_srgb(vec3 encoded) {
  return mix(pow((encoded + 0.055) / 1.055, vec3(2.4)), encoded / 12.92, lessThanEqual(encoded, vec3(0.04045)));
}

// Kernels are trained and blended in display-encoded sRGB (KHR_gaussian_splatting: before any conversion).
// After the background is added the light is decoded; the sRGB attachment encodes it again.
void main() {
  const int eye = int(constants.first_eye) + gl_ViewIndex;
  const vec4 sum = texelFetch(blended, ivec3(ivec2(gl_FragCoord.xy), eye), 0);
  const vec3 background = vec3(constants.red, constants.green, constants.blue);
  const vec3 encoded = clamp(sum.rgb + (1.0 - sum.a) * background, vec3(0.0), vec3(1.0));
  linear_light = vec4(decode_srgb(encoded), sum.a);
}
