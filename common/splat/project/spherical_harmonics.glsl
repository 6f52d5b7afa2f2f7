// SPDX-License-Identifier: Apache-2.0
// GLSL twin of spherical_harmonics.cpp. Include after the buffer `bands_of`, which has coefficients as half
// floats.

const float kShDc = 0.28209479;

// Sum of all bands above the first in a unit direction, not clamped. Two coefficients are three words: r g, b
// r, g b.
vec3 bands_towards(vec3 direction, uint degree, uint first_word) {
  const float x = direction.x, y = direction.y, z = direction.z;
  const float xx = x * x, yy = y * y, zz = z * z;
  const float bands[16] = float[16](
      -0.48860251 * y, 0.48860251 * z, -0.48860251 * x,
      1.09254843 * x * y, -1.09254843 * y * z, 0.31539157 * (2.0 * zz - xx - yy), -1.09254843 * x * z,
      0.54627422 * (xx - yy),
      -0.59004359 * y * (3.0 * xx - yy), 2.89061144 * x * y * z, -0.45704580 * y * (4.0 * zz - xx - yy),
      0.37317633 * z * (2.0 * zz - 3.0 * xx - 3.0 * yy), -0.45704580 * x * (4.0 * zz - xx - yy),
      1.44530572 * z * (xx - yy), -0.59004359 * x * (xx - 3.0 * yy), 0.0);
  const uint count = (degree + 1) * (degree + 1) - 1;
  vec3 sum = vec3(0.0);
  uint word = first_word;
  for (uint b = 0; b < 15; b += 2) {
    if (b >= count) break;
    const vec2 first = unpackHalf2x16(bands_of[word]);
    const vec2 middle = unpackHalf2x16(bands_of[word + 1]);
    sum += bands[b] * vec3(first, middle.x);
    if (b + 1 < count) sum += bands[b + 1] * vec3(middle.y, unpackHalf2x16(bands_of[word + 2]));
    word += 3;
  }
  return sum;
}
