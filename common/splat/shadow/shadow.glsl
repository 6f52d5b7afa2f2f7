// SPDX-License-Identifier: Apache-2.0
// GLSL twin of shadow_light(). Include after shadow_layout.h and the buffer `shadow_words`.

float shadow_float(uint place) { return uintBitsToFloat(shadow_words[place]); }

vec4 shadow_texel(uint place) {
  return vec4(shadow_float(place), shadow_float(place + 1), shadow_float(place + 2), shadow_float(place + 3));
}

float shadow_darkness(uint body, vec3 at_m) {
  const float top = shadow_float(body + kShadowHeights);
  const float bottom = shadow_float(body + kShadowHeights + 5);
  if (!(at_m.y < top && at_m.y > bottom)) return 0.0;
  const float scale = shadow_float(body + kShadowScale);
  const float x = scale * (at_m.x - shadow_float(body + kShadowX));
  const float z = scale * (at_m.z - shadow_float(body + kShadowZ));
  const uint texels_x = shadow_words[body + kShadowTexelsX];
  const uint texels_z = shadow_words[body + kShadowTexelsZ];
  if (!(x >= 0.0 && z >= 0.0 && x < float(texels_x - 1) && z < float(texels_z - 1))) return 0.0;
  const uint column = uint(x);
  const uint row = uint(z);
  const uint texel = shadow_words[body + kShadowTexels] + 4 * (row * texels_x + column);
  const float right = x - float(column);
  const float below = z - float(row);
  const vec4 near = mix(shadow_texel(texel), shadow_texel(texel + 4), right);
  const vec4 far = mix(shadow_texel(texel + 4 * texels_x), shadow_texel(texel + 4 * texels_x + 4), right);
  const vec4 dark = mix(near, far, below);
  float sum = 0.0;
  for (uint level = 0; level < 4; ++level) {
    const float above = (shadow_float(body + kShadowHeights + level) - at_m.y) * shadow_float(body + kShadowSlopes + level);
    const float under =
        (at_m.y - shadow_float(body + kShadowHeights + level + 2)) * shadow_float(body + kShadowSlopes + level + 1);
    sum += clamp(min(above, under), 0.0, 1.0) * dark[level];
  }
  return sum;
}

float shadow_light(vec3 at_m, uint object_id) {
  const uint cells_x = shadow_words[kShadowGridCellsX];
  const uint cells_z = shadow_words[kShadowGridCellsZ];
  if (cells_x == 0) return 1.0;
  const float scale = shadow_float(kShadowGridScale);
  const float x = scale * (at_m.x - shadow_float(kShadowGridX));
  const float z = scale * (at_m.z - shadow_float(kShadowGridZ));
  if (!(x >= 0.0 && z >= 0.0 && x < float(cells_x) && z < float(cells_z))) return 1.0;
  const uint start = shadow_words[kShadowGridStarts] + uint(z) * cells_x + uint(x);
  float light = 1.0;
  for (uint entry = shadow_words[start]; entry < shadow_words[start + 1]; ++entry) {
    const uint body = shadow_words[entry];
    if (shadow_words[body + kShadowObject] != object_id) light *= 1.0 - shadow_darkness(body, at_m);
  }
  return light;
}
